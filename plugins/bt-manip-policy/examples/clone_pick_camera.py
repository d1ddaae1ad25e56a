"""Clone the pick of pick_place from the pictures of the wrist camera, and write it as ONNX.

    bt-manip demos pick_place --episodes 200 --to demos --images panda/wrist --size 64x64
    python clone_pick_camera.py demos first.onnx
    bt-manip demos pick_place_policy --episodes 30 --seed 2 --all --to own \
        --set policy=first.onnx --set fallback=false --set attempts=1 \
        --images panda/wrist --size 64x64
    python clone_pick_camera.py demos camera.onnx --own own
    bt-manip run pick_place_policy --set policy=camera.onnx --set fallback=false

A convolutional network estimates the pose of the cube from a picture and the pose of the tool; the
policy of clone_pick.py, trained on the same demonstrations, acts on the estimate. The scripted pick
is always above the cube and aligned with it when it is near; with --own, the network also learns
from what an earlier policy saw (DAgger, Ross et al., 2011).
"""

import argparse
import time
from pathlib import Path

import torch
from clone_pick import INPUTS, ClonedPick, Gripped, chosen, export, read, train, yaw_of
from torch import nn

CAMERA, SIZE = "panda_wrist_rgb", 64
TABLE = 1.0  # [m] its height
TESTED = 0.1  # fraction of the demonstrations for validation


class CubePose(nn.Module):
    """Estimates the pose of the cube from an image of the wrist camera and the tool's pose.

    The network returns the position in the tool frame divided by the height of the tool, as in an
    image, and the yaw relative to the tool times four, since a cube looks the same after a quarter
    turn.
    """

    def __init__(self) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels = (3, 16, 32, 32, 32)
        for before, after in zip(channels, channels[1:], strict=False):
            layers += [nn.Conv2d(before, after, 3, stride=2, padding=1), nn.ReLU()]
        self.picture = nn.Sequential(*layers, nn.Flatten(), nn.Linear(32 * (SIZE // 16) ** 2, 128))
        self.head = nn.Sequential(nn.ReLU(), nn.Linear(128 + 10, 128), nn.ReLU(), nn.Linear(128, 5))

    def forward(self, picture, tool, axes, opening):
        """Return position over height in the tool frame, cosine and sine of four times the yaw."""
        seen = picture.float().permute(0, 3, 1, 2) / 255.0 - 0.5
        return self.head(torch.cat([self.picture(seen), tool, axes, opening], -1))  # (n, 5)

    def pose(self, estimate, tool, axes):
        """Return position [m] and axes of the cube in the world from an estimate."""
        position = tool + _rotated(axes, estimate[:, :3] * _height(tool))
        yaw = yaw_of(axes) + torch.atan2(estimate[:, 4:], estimate[:, 3:4]) / 4.0
        cos, sin, zero = torch.cos(yaw), torch.sin(yaw), torch.zeros_like(yaw)
        return position, torch.cat([cos, sin, zero, -sin, cos, zero], -1)


class CameraPick(nn.Module):
    """The policy of clone_pick.py, applied to the estimated pose of the cube."""

    def __init__(self, cube: CubePose, policy: ClonedPick) -> None:
        super().__init__()
        self.cube, self.policy = cube, Gripped(policy)

    def forward(self, picture, tool, axes, opening):
        """Return the action for one observation."""
        picture, tool, axes, opening = (one[None] for one in (picture, tool, axes, opening))
        pose = self.cube.pose(self.cube(picture, tool, axes, opening), tool, axes)
        return self.policy(tool, axes, opening, *pose)[0]


def targets(tool, axes, position, cube_axes):
    """Return the target of the network for a pose of the cube."""
    between = _rotated(axes, position - tool, inverse=True) / _height(tool)
    turn = 4.0 * (yaw_of(cube_axes) - yaw_of(axes))
    return torch.cat([between, torch.cos(turn), torch.sin(turn)], -1)


def fit(network: CubePose, pictures, observations, steps: int, seed: int) -> None:
    """Fit the estimate, and print its error on validation demonstrations."""
    rng = torch.Generator().manual_seed(seed)
    tool, axes, opening, *cube = observations
    wanted = targets(tool, axes, *cube)
    learned = int((1.0 - TESTED) * len(wanted))
    optimizer = torch.optim.Adam(network.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 1e-3, total_steps=steps)
    start = time.perf_counter()
    for step in range(1, steps + 1):
        rows = torch.randint(0, learned, (64,), generator=rng)
        given = network(pictures[rows], tool[rows], axes[rows], opening[rows])
        scale = torch.tensor([10.0, 10.0, 10.0, 1.0, 1.0])
        loss = nn.functional.huber_loss(scale * given, scale * wanted[rows])
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        if step % (steps // 10) == 0:
            with torch.no_grad():
                rows = torch.randint(learned, len(wanted), (1000,), generator=rng)
                given = network(pictures[rows], tool[rows], axes[rows], opening[rows])
                found = network.pose(given, tool[rows], axes[rows])
            off = (found[0] - cube[0][rows]).norm(dim=1).median()
            print(
                f"step {step}: loss {loss:.4f}, cube off by {1e3 * off:.1f} mm in the median, "
                f"{time.perf_counter() - start:.0f} s",
                flush=True,
            )


def _height(tool):
    return tool[:, 2:] - TABLE + 0.1  # [m] approximate height of the camera over the table


def _rotated(axes, vector, inverse: bool = False):
    """Rotate a vector from the frame with these axes to the world, or inversely."""
    x, y = axes[:, :3], axes[:, 3:]
    R = torch.stack([x, y, torch.linalg.cross(x, y)], dim=-1)
    return ((R.transpose(1, 2) if inverse else R) @ vector[..., None])[..., 0]


def main() -> None:
    """Read, train and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("demonstrations", type=Path, help="folder of bt-manip demos")
    parser.add_argument("policy", type=Path, help="ONNX file to write")
    parser.add_argument("--steps", type=int, default=1200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--own", type=Path, help="folder of episodes of an earlier policy")
    options = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(options.seed)
    names = [CAMERA, *INPUTS.values()]
    (pictures, *observations), actions = read(options.demonstrations, names)
    seen = [pictures, *observations]
    if options.own:
        seen = [torch.cat(both) for both in zip(seen, read(options.own, names)[0], strict=True)]
    cube = CubePose()
    fit(cube, seen[0], seen[1:], options.steps, options.seed)
    pick = ClonedPick()
    rows = chosen(pick, observations, actions)
    train(pick, [o[rows] for o in observations], actions[rows], 6000, options.seed)
    inputs = zip([CAMERA, *INPUTS], [pictures, *observations], strict=True)
    example = {name: one[0] for name, one in inputs if not name.startswith("object_")}
    export(CameraPick(cube, pick).eval(), example, options.policy)


if __name__ == "__main__":
    main()
