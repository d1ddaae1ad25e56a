"""Clone the pick of pick_place from demonstrations, and write the policy as ONNX.

    bt-manip demos pick_place --episodes 500 --to demos
    python clone_pick.py demos pick.onnx
    bt-manip run pick_place_policy --set policy=pick.onnx

It needs the extra: pip install ./plugins/bt-manip-learn "./plugins/bt-manip-policy[train]"
"""

import argparse
import math
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import onnx
import torch
from torch import nn

from bt_manip_learn.demonstrations import read_demonstrations

INPUTS = {  # observations of the policy, and their names in the demonstrations
    "robot_tool_position": "robot_tool_position",
    "robot_tool_rotation": "robot_tool_rotation",
    "robot_gripper_opening": "robot_gripper_opening",
    "object_position": "cube_position",
    "object_rotation": "cube_rotation",
}
ACTION, RATE = "cartesian_deltas", 20
BASE = (-0.1, 0.0)  # [m] the robot's, on the table
NEAR = 0.03  # [m] within which the features have a finer scale
OPEN = 0.9  # opening above which the gripper is open
SPEED = 0.6  # relative to the demonstrations, which use the arm's limits: a reserve for corrections
RETURN = 0.3  # share of a deviation from the path corrected by one action
LARGEST = 4.0  # largest action, in units of SCALE
SCALE = (0.02, 0.02, 0.02, 0.04, 0.04, 0.08)  # of the deltas [m, rad]


class ClonedPick(nn.Module):
    """A multilayer perceptron on features that are invariant under quarter turns of the cube.

    A cube looks the same after a quarter turn, so four yaws of the gripper are equivalent. The
    features refer to the yaw nearest to the direction from the robot's base to the cube, which does
    not change during the motion.
    """

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(13))
        self.register_buffer("std", torch.ones(13))
        self.register_buffer("scale", torch.tensor([*SCALE, 1.0]))
        self.layers = nn.Sequential(
            nn.Linear(13, 128), nn.ReLU(),
            nn.Linear(128, 128), nn.ReLU(),
            nn.Linear(128, 7),
        )  # fmt: skip

    def features(self, tool, tool_axes, opening, cube, cube_axes):
        """Return the features of observations."""  # (..., 13)
        between = tool - cube
        near = torch.clip(between - torch.tensor([0.0, 0.0, 0.015]), -NEAR, NEAR)
        azimuth = torch.atan2(cube[..., 1:2] - BASE[1], cube[..., 0:1] - BASE[0])
        quarter = math.pi / 2.0
        yaw = azimuth + _wrapped(yaw_of(cube_axes) - azimuth, quarter)
        turn = _wrapped(yaw_of(tool_axes) - yaw, 2.0 * math.pi)
        tilt = torch.cat([tool_axes[..., 2:3], tool_axes[..., 5:6]], -1)  # z of the x and y axes
        return torch.cat([between, tool, near, turn, tilt, opening], -1)

    def forward(self, *observations):
        """Return the action: displacement and rotation of the tool, and the gripper's value."""
        features = (self.features(*observations) - self.mean) / self.std
        return LARGEST * torch.tanh(self.layers(features) / LARGEST) * self.scale


class Gripped(nn.Module):
    """A policy whose gripper opens or closes at the start of the step."""

    def __init__(self, policy: ClonedPick) -> None:
        super().__init__()
        self.policy = policy

    def forward(self, *observations):
        """Return the action with -1 or 1 for the gripper."""
        action = self.policy(*observations)
        return torch.cat([action[..., :6], 2.0 * (action[..., 6:] > 0.0).float() - 1.0], -1)


def read(folder: Path, names: Iterable[str]) -> tuple[list[torch.Tensor], torch.Tensor]:
    """Return observations and actions of the picks in a folder of demonstrations."""
    observations: dict[str, list[np.ndarray]] = {name: [] for name in names}
    actions = []
    for demonstration in read_demonstrations(folder):
        n = next(
            (i for i, leaf in enumerate(demonstration.leaves) if "Drop" in leaf), len(demonstration)
        )
        for name, rows in observations.items():
            rows.append(demonstration.observations[name][:n])
        actions.append(demonstration.actions[ACTION][:n])
    tensors = [torch.from_numpy(np.concatenate(rows)) for rows in observations.values()]
    return tensors, torch.tensor(np.concatenate(actions), dtype=torch.float32)


def chosen(policy: ClonedPick, observations: list[torch.Tensor], actions: torch.Tensor):
    """Return the mask of the rows to learn from.

    It excludes rows before the first motion, and rows after the expert turned to another yaw than
    that of the features.
    """
    still = (actions[:, :3].norm(dim=1) < 1e-3) & (actions[:, 3:6].norm(dim=1) < 2e-3)
    idle = still & (observations[2][:, 0] > OPEN) & (actions[:, 6] < 0.0)
    turn = policy.features(*observations)[:, 9].abs()
    between = (observations[0] - observations[3]).norm(dim=1)
    return ~idle & ~((between < 0.3) & (turn > 0.2))


def perturbed(observations: list[torch.Tensor], actions: torch.Tensor, rng: torch.Generator):
    """Displace the open gripper from the demonstrated path, with actions that return to it.

    Displacements increase with the height of the gripper. An open gripper away from the expert's
    closing pose stays open.
    """
    tool, axes, opening, cube, cube_axes = observations
    n = len(actions)
    height = (tool - cube)[:, 2:]
    size = torch.rand(n, 1, generator=rng) * (torch.rand(n, 1, generator=rng) > 0.2)
    size = size * (opening > OPEN) * (0.015 + 0.1 * (height - 0.02).clip(0.0, 0.4))
    shift = size * torch.randn(n, 3, generator=rng) * torch.tensor([1.0, 1.0, 0.5])
    turn = 5.0 * size * torch.randn(n, 3, generator=rng) * torch.tensor([0.2, 0.2, 1.0])
    wanted = actions * torch.tensor([SPEED] * 6 + [1.0])
    wanted[:, :3] -= RETURN * shift
    wanted[:, 3:6] -= RETURN * turn
    off = (shift[:, :2].norm(dim=1) > 0.004) | (shift[:, 2].abs() > 0.006)
    wanted[off | (turn.norm(dim=1) > 0.06), 6] = -1.0
    return [tool + shift, _turned(axes, turn), opening, cube, cube_axes], wanted


def train(policy: ClonedPick, observations, actions, steps: int, seed: int) -> None:
    """Fit a policy to the actions."""
    rng = torch.Generator().manual_seed(seed)
    features = policy.features(*observations)
    policy.mean[:], policy.std[:] = features.mean(0), features.std(0) + 1e-3
    optimizer = torch.optim.Adam(policy.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 3e-3, total_steps=steps)
    start = time.perf_counter()
    for step in range(steps):
        rows = torch.randint(0, len(actions), (256,), generator=rng)
        seen, wanted = perturbed([o[rows] for o in observations], actions[rows], rng)
        error = (policy(*seen) - wanted) / policy.scale
        moved = nn.functional.huber_loss(error[:, :6], torch.zeros(256, 6), delta=0.3)
        gripped = nn.functional.softplus(-4.0 * policy(*seen)[:, 6] * wanted[:, 6].sign())
        loss = 3.0 * moved + 0.2 * gripped.mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        if step % (steps // 10) == 0:
            print(f"step {step}: loss {loss:.4f}, {time.perf_counter() - start:.0f} s", flush=True)


def export(policy: nn.Module, example: dict[str, torch.Tensor], path: Path) -> None:
    """Write a policy with its specification; `example` has an observation of each input."""
    torch.onnx.export(
        policy, tuple(example.values()), str(path), input_names=[*example],
        output_names=["action"], dynamo=False, opset_version=17,
    )  # fmt: skip
    model = onnx.load(path)
    onnx.helper.set_model_props(model, {"bt_manip.action": ACTION, "bt_manip.rate": str(RATE)})
    onnx.save(model, path)


def _wrapped(angle, period: float):
    """Return an angle within half a period of zero."""
    return angle - period * torch.round(angle / period)


def _turned(axes, turn):
    """Return two axes after a small rotation, a rotation vector."""
    x, y = axes[:, :3], axes[:, 3:]
    x, y = x + torch.linalg.cross(turn, x), y + torch.linalg.cross(turn, y)
    return torch.cat([nn.functional.normalize(x, dim=1), nn.functional.normalize(y, dim=1)], 1)


def yaw_of(axes):
    """Return the yaw of frames with these x and y axes."""
    return torch.atan2(axes[..., 1:2], axes[..., 0:1])


def main() -> None:
    """Read, train and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("demonstrations", type=Path, help="folder of bt-manip demos")
    parser.add_argument("policy", type=Path, help="ONNX file to write")
    parser.add_argument("--steps", type=int, default=6000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    torch.set_num_threads(1)  # a network as small as this is no faster in more
    torch.manual_seed(options.seed)
    observations, actions = read(options.demonstrations, INPUTS.values())
    policy = ClonedPick()
    rows = chosen(policy, observations, actions)
    print(f"{int(rows.sum())} of {len(rows)} steps")
    train(policy, [o[rows] for o in observations], actions[rows], options.steps, options.seed)
    example = {name: one[0] for name, one in zip(INPUTS, observations, strict=True)}
    export(Gripped(policy).eval(), example, options.policy)


if __name__ == "__main__":
    main()
