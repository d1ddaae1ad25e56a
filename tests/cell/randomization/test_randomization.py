"""Each value follows from seed, cycle and name, and from nothing else."""

import json

import numpy as np
import pinocchio as pin
import pytest
from dm_control.composer.observation import updater
from dm_control.composer.variation import distributions, noises

from bt_manip import build_station
from bt_manip.behaviours import payload_of
from bt_manip.cell import Cell, CellError
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import InitialObject, Randomization, Randomizer, parse_variation
from bt_manip.cell.randomization.variations import extremes, sample, stream
from bt_manip.spatial import pose

SCENE = {
    "table": InitialObject("table", pose((0.0, 0.0, 0.0))),
    "cube": InitialObject("cube", pose((0.2, 0.0, 1.04)), {"mass": 0.1}, free=True),
    "can": InitialObject("can", pose((-0.2, 0.0, 1.015)), free=True),
}


class Varied:
    """A cell with some things, and what varies them."""

    def __init__(self, parts, seed: int = 0, scene=SCENE, reached=None, **lines) -> None:
        self.cell, self.catalogue, self.scene = Cell(), Catalogue(parts.objects), scene
        with self.cell.editing():
            for name, stand in scene.items():
                entity = self.catalogue.create(stand.model, **stand.parameters)
                self.cell.add(entity, stand.T_wo, name=name, free=stand.free)
        self.randomizer = self.randomize(seed, reached, **lines)

    def randomize(self, seed: int = 0, reached=None, **lines) -> Randomizer:
        return Randomizer(
            Randomization(**lines), self.cell, self.catalogue, seed=seed,
            scene_objects=self.scene, reached=reached or {},
        )  # fmt: skip

    def begin(self, cycle: int) -> dict:
        self.randomizer.begin(cycle)
        return self.randomizer.sampled


@pytest.fixture(scope="module")
def unvaried(parts) -> Varied:
    return Varied(parts)


@pytest.fixture(scope="module")
def without_cube(parts) -> Varied:
    return Varied(parts, scene={name: one for name, one in SCENE.items() if name != "cube"})


MASS, NOISE = {"mass": distributions.Uniform(0.05, 0.3)}, distributions.Normal(0.02, 0.01)


def test_the_same_seed_and_cycle_give_the_same_bits_in_any_order(parts):
    lines = {"objects": {"cube": MASS, "can": {"friction": distributions.Normal(1.0, 0.1)}}}
    one, other = Varied(parts, 7, **lines), Varied(parts, 7, **lines)
    first = [one.begin(cycle) for cycle in range(4)]
    np.random.seed(2)  # the global random numbers are neither used nor changed
    before = np.random.get_state()[1].tobytes()
    assert [other.begin(cycle) for cycle in (3, 1, 0, 2)] == [first[i] for i in (3, 1, 0, 2)]
    masses = {drawn["objects"]["cube"]["mass"] for drawn in first}
    assert len(masses) == 4
    assert all(0.05 <= mass <= 0.3 for mass in masses)
    assert np.random.get_state()[1].tobytes() == before
    assert Varied(parts, 8, **lines).begin(0) != first[0]


def test_a_line_more_leaves_all_other_draws_as_they_were(parts):
    alone = Varied(parts, objects={"cube": MASS}).begin(0)
    more = Varied(
        parts,
        objects={"can": MASS, "cube": {**MASS, "friction": distributions.Uniform(0.5, 1.0)}},
        lights={"key": {"brightness": distributions.Uniform(0.5, 1.0)}},
    ).begin(0)
    assert more["objects"]["cube"]["mass"] == alone["objects"]["cube"]["mass"]
    assert more["objects"]["can"]["mass"] != more["objects"]["cube"]["mass"]


def test_what_was_drawn_is_what_is_simulated(parts):
    varied = Varied(
        parts,
        objects={"cube": {**MASS, "friction": noises.Multiplicative(distributions.Uniform(2, 3))}},
        lights={"key": {"brightness": 0.5}, "fill": {"position": distributions.Uniform(1.0, 2.0)}},
        cameras={"overview": {"fovy": noises.Additive(distributions.Uniform(5.0, 6.0))}},
    )
    nominal = varied.cell.nominal("cube", "friction")
    drawn = varied.begin(0)
    cell, cube = varied.cell, drawn["objects"]["cube"]
    model = cell.model
    assert model.body_subtreemass[cell.body_id("cube")] == pytest.approx(cube["mass"], rel=1e-12)
    assert 2 * nominal <= cube["friction"] <= 3 * nominal
    assert cell.overrides["cube"] == cube
    assert model.camera("overview").fovy == drawn["cameras"]["overview"]["fovy"]
    assert 41.0 <= drawn["cameras"]["overview"]["fovy"] <= 42.0  # the arena's is 36 degrees
    np.testing.assert_allclose(
        model.light("fill").pos, drawn["lights"]["fill"]["position"], rtol=1e-12
    )
    json.dumps(drawn)


def test_sizes_are_those_of_what_is_made_anew_and_still_stands_where_it_stood(parts):
    T_wo = pose((0.2, 0.0, 1.04), (0.5**0.5, 0.5**0.5, 0.0, 0.0))
    lines = {"size": distributions.Uniform(0.03, 0.04), "yaw": distributions.Uniform(0.3, 1.0)}
    scene = SCENE | {"cube": InitialObject("cube", T_wo, {"mass": 0.1}, free=True)}
    varied = Varied(parts, scene=scene, objects={"cube": lines})
    size, yaw = (varied.begin(0)["objects"]["cube"][name] for name in lines)
    turned = pin.utils.rotate("z", yaw) @ T_wo.rotation
    assert varied.cell.pose("cube").rotation == pytest.approx(turned)
    cube = varied.cell.find("cube")
    assert cube.size == pytest.approx(size)
    assert cube.parameters["mass"] == 0.1
    bottom = varied.cell.pose("cube").translation - (0, 0, cube.rest_height)
    np.testing.assert_allclose(bottom, (0.2, 0.0, 1.015), atol=1e-9)
    again = varied.begin(1)["objects"]["cube"]["size"]
    assert again != size
    assert varied.cell.find("cube").size == pytest.approx(again)


def test_poses_are_drawn_until_they_are_free(parts):
    # Half of these places are inside the can.
    across = parse_variation({"choice": [[-0.2, 0.0, 1.04], [0.2, 0.2, 1.04]]})
    varied = Varied(
        parts, objects={"cube": {"position": across, "yaw": distributions.Uniform(-1.0, 1.0)}}
    )
    for cycle in range(5):
        drawn = varied.begin(cycle)["objects"]["cube"]
        assert drawn["position"] == [0.2, 0.2, 1.04]
        R = varied.cell.pose("cube").rotation
        assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(drawn["yaw"])


def test_poses_out_of_reach_are_not_sampled(parts):
    positions = distributions.Uniform((0.0, -0.3, 1.04), (0.4, 0.3, 1.04))
    free = Varied(parts, objects={"cube": {"position": positions}})
    accepted = {"cube": lambda T_wo: T_wo.translation[1] > 0.0}
    reached = Varied(parts, objects={"cube": {"position": positions}}, reached=accepted)
    for cycle in range(6):
        y = [one.begin(cycle)["objects"]["cube"]["position"][1] for one in (free, reached)]
        assert y[1] > 0.0
        assert y[0] == y[1] or y[0] <= 0.0
    accepted["cube"] = lambda T_wo: False
    with pytest.raises(CellError, match="no free pose for 'cube' .* no robot reaches it at"):
        reached.begin(0)


def test_where_no_place_is_free_it_says_so(parts):
    varied = Varied(parts, objects={"cube": {"position": (-0.2, 0.0, 1.04)}})
    with pytest.raises(CellError, match=r"no free pose for 'cube' in 100 attempts.*inside 'can'"):
        varied.begin(0)


def test_what_comes_later_is_varied_as_it_comes(parts):
    lines = {"objects": {"cube": {**MASS, "size": distributions.Uniform(0.03, 0.04)}}}
    varied = Varied(parts, **lines)
    varied.begin(0)
    cell = varied.cell
    names = []
    for x in (1.0, 2.0):
        entity = varied.catalogue.create("cube")
        names.append(cell.add(entity, pose((x, 0.0, entity.rest_height))))
    drawn = varied.randomizer.sampled["objects"]
    assert names == ["cube_1", "cube_2"]
    for name in names:
        assert cell.overrides[name]["mass"] == drawn[name]["mass"]
    assert len({drawn[name]["mass"] for name in ("cube", *names)}) == 3
    assert cell.find("cube_1").size == pytest.approx(drawn["cube"]["size"])
    assert cell.find("cube_2").size == pytest.approx(drawn["cube (2)"]["size"])


def test_a_pattern_means_all_names_that_fit(parts):
    varied = Varied(parts, objects={"c*": MASS, "later_*": MASS})
    assert varied.begin(0)["objects"].keys() == {"cube", "can"}
    assert varied.randomizer.absent == ["later_*"]
    all_free = Varied(parts, objects={"*": MASS}).begin(0)["objects"]
    assert all_free.keys() == {"cube", "can"}


def test_planners_and_controllers_know_nothing_of_what_was_drawn(parts):
    station = build_station(parts)
    cell = station.cell
    cell.add(station.models.create("cube", mass=0.1), pose((0.3, 0.0, 1.04)))
    before = payload_of(cell, "cube", station.robot.tool_pose)
    lines = {"cube": {"mass": 0.4}}
    robots = {"panda": {"gain": 0.9}}
    Randomizer(
        Randomization(objects=lines, robots=robots), cell, station.models,
        seed=0, scene_objects={}, robots=("panda",),
    ).begin(0)  # fmt: skip
    assert cell.model.body_subtreemass[cell.body_id("cube")] == pytest.approx(0.4)
    assert cell.overrides["panda"]["gain"] == [0.9] * 9
    known = payload_of(cell, "cube", station.robot.tool_pose)
    assert known.mass == before.mass == pytest.approx(0.1)
    np.testing.assert_array_equal(known.inertia, before.inertia)


def observed(varied: Varied, steps: int, seed: int = 0) -> np.ndarray:
    """Read an observable as composer's environments do."""
    cube = varied.cell.find("cube")
    cube.observables.position.enabled = True
    reader = updater.Updater({"position": cube.observables.position})
    reader.reset(varied.cell.physics, np.random.RandomState(seed))
    seen = []
    for _ in range(steps):
        reader.prepare_for_next_control_step()
        varied.cell.step()
        reader.update()
        seen.append(reader.get_observation()["position"][0])
    return np.array(seen)  # (steps, 3)


def test_observations_are_as_noisy_as_asked(parts):
    def noisy(steps: int, noise=NOISE) -> np.ndarray:
        varied = Varied(parts, observations={"cube/position": {"noise": noise}})
        varied.begin(0)
        return observed(varied, steps) - varied.cell.pose("cube").translation

    many = noisy(500)
    assert (many.mean(), many.std()) == pytest.approx((0.02, 0.01), rel=0.1)
    assert np.array_equal(noisy(5), noisy(5))
    for scale in ({"times": 1.5}, {"times": 1.5, "within": [-9.0, 9.0]}):  # instead of the value
        assert noisy(1, parse_variation(scale))[0] == pytest.approx([0.1, 0.0, 0.52], abs=1e-3)


def test_observations_are_as_late_as_drawn(parts):
    varied = Varied(
        parts, observations={"c*/position": {"delay": parse_variation({"integer": [3, 9]})}}
    )
    delay = int(varied.begin(0)["observations"]["cube/position"]["delay"])
    assert 3 <= delay <= 9
    prompt = Varied(parts)
    for one in (varied, prompt):
        one.cell.data.qvel[:] = 0.3  # so that there is something to be late about
    late, true = observed(varied, 30), observed(prompt, 30)
    np.testing.assert_array_equal(late[delay:], true[: 30 - delay])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ({"objects": {"cubee": MASS}}, "objects 'cubee' neither stands .* did you mean 'cube'"),
        ({"objects": {"cube": {"sise": 1}}}, "objects 'cube': 'sise' cannot vary; did .* 'size'"),
        ({"objects": {"sphere": {"size": 1}}}, "'sphere': 'size' cannot vary.*radius.* can"),
        ({"robots": {"panda": {"gain": 1}}}, "robots 'panda' is not there"),
        ({"robots": {"panda": {"mass": 1}}}, "robots 'panda': 'mass' cannot vary.*gain"),
        ({"lights": {"kez": {"brightness": 1}}}, "no light 'kez' in the cell; did you mean 'key'"),
        ({"lights": {"key": {"bright": 1}}}, "'bright' cannot vary; did you mean 'brightness'"),
        ({"cameras": {"overview": {"fov": 1}}}, "'fov' cannot vary; did you mean 'fovy'"),
        ({"observations": {"cube/position": {"nose": 1}}}, "did you mean 'noise'"),
    ],
)
def test_what_there_is_not_cannot_vary(unvaried, lines, message):
    with pytest.raises(CellError, match=message):
        unvaried.randomize(**lines)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ({"objects": {"cube": {"mass": -1.0}}}, r"mass of 'cube' is a number above 0 .*\[kg\]"),
        ({"objects": {"cube": {"size": -0.1}}}, "'cube' cannot be made as sampled: size must be"),
        ({"objects": {"cube": {"gain": 1.0}}}, "it has no actuators"),
        ({"objects": {"cube": {"mass": distributions.Uniform((1, 2), 3)}}}, "cannot be drawn"),
        ({"observations": {"cube/place": {"delay": 1}}}, "no observable 'place'"),
        ({"observations": {"cube/position": {"delay": -1}}}, "is a number of steps, got -1"),
        ({"observations": {"cube/position": {"delay": 1.5}}}, "is a number of steps, got 1.5"),
    ],
)
def test_what_is_drawn_and_impossible_is_an_error(unvaried, lines, message):
    with pytest.raises(CellError, match=message):
        unvaried.randomize(**lines).begin(0)


@pytest.mark.parametrize(
    ("data", "low", "high"),
    [
        (0.3, 0.3, 0.3),
        ({"uniform": [0.1, 0.2]}, 0.1, 0.2),
        ({"integer": [2, 4]}, 2, 4),
        ({"integer": [-(2**31) + 1, 2**31 - 1]}, -(2**31) + 1, 2**31 - 1),
        ({"choice": [1.0, 5.0]}, 1.0, 5.0),
        ({"times": {"uniform": [0.5, 2.0]}}, 5.0, 20.0),
        ({"plus": {"uniform": [-1.0, 1.0]}}, 9.0, 11.0),
        ({"normal": [0.0, 9.0], "within": [-1.0, 1.0]}, -1.0, 1.0),
        ({"log_normal": [0.0, 0.1], "within": [0.8, 1.2]}, 0.8, 1.2),
    ],
)
def test_variations_are_written_as_plain_data(data, low, high):
    variation = parse_variation(data)
    assert extremes(variation, 10.0) == pytest.approx([low, high])
    values = [sample(variation, 10.0, stream(0, cycle)) for cycle in range(300)]
    assert low <= min(values)
    assert max(values) <= high
    spread = high - low
    assert min(values) <= low + 0.05 * spread
    assert max(values) >= high - 0.05 * spread


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("heavy", "a value is a number or a list of numbers, got 'heavy'"),
        (True, "a number or a list of numbers"),
        ({}, "a variation is a value, or a table with one of: uniform"),
        ({"uniform": [0, 1], "normal": [0, 1]}, "with one of"),
        ({"unifrom": [0, 1]}, "'unifrom' is no variation; did you mean 'uniform'"),
        ({"uniform": [1, 0]}, "'uniform' goes from low to high"),
        ({"uniform": 3}, "'uniform' is two values, got 3"),
        ({"normal": [0, -1]}, "the second value of 'normal' is not negative"),
        ({"integer": [0, 1.5]}, "is a range of whole numbers"),
        ({"integer": [-(2**31), 0]}, "'integer' goes up to 2147483647"),
        ({"choice": []}, "'choice' is a list of values"),
        ({"choice": [1, [1, 2]]}, "the values of 'choice' must have the same shape"),
        ({"plus": {"uniform": [1, 0]}}, "'uniform' goes from low to high"),
        ({"normal": [0, 1], "within": [1, 0]}, "'within' goes from low to high"),
    ],
)
def test_what_is_no_variation_is_refused(data, message):
    with pytest.raises(CellError, match=message):
        parse_variation(data)


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        ({"mass": {"uniform": [-1, 1]}}, r"mass .* number above 0 .*\[kg\], got -1"),
        ({"mass": {"normal": [0.1, 0.05]}}, r"mass .* number above 0 .*\[kg\], got -0.2"),
        ({"mass": {"choice": [1, -1]}}, r"mass .* number above 0 .*\[kg\], got -1"),
        ({"mass": {"times": {"uniform": [-1, 1]}}}, r"mass .* number above 0 .*\[kg\], got -0"),
        ({"mass": {"plus": -1}}, r"mass .* number above 0 .*\[kg\], got -0"),
        ({"mass": {"normal": [1, 1], "within": [0, 2]}}, r"mass .* number above 0 .*\[kg\], got 0"),
        ({"mass": {"log_normal": [1e3, 1]}}, "mass can be sampled as inf"),
        ({"friction": {"uniform": [-0.1, 1]}}, "friction .* positive number.*, got -0.1"),
        ({"size": {"uniform": [-0.1, 0.1]}}, r"size must be a positive number \[m\], got -0.1"),
        ({"position": [1, 2]}, "position is 3 numbers"),
        ({"yaw": {"uniform": [[0, 0], [1, 1]]}}, "yaw cannot be drawn"),
    ],
    ids=str,
)
def test_what_could_be_drawn_is_checked_before_the_first_cycle(
    unvaried, without_cube, varied, message
):
    lines = {"cube": {key: parse_variation(data) for key, data in varied.items()}}
    for given in (unvaried, without_cube):  # it may be added later
        with pytest.raises(CellError, match=message):
            given.randomize(objects=lines)


def test_distributions_that_cannot_go_wrong_are_accepted(unvaried, without_cube):
    lines = {
        "mass": {"normal": [0.1, 0.01]}, "friction": {"log_normal": [0, 1]},
        "size": {"normal": [0.04, 1], "within": [0.03, 0.05]},
        "colour": {"uniform": [0, 1]},
    }  # fmt: skip
    for given in (unvaried, without_cube):
        given.randomize(objects={"cube": {k: parse_variation(v) for k, v in lines.items()}})


def test_nothing_is_drawn_from_the_global_randomness(unvaried):
    def drawn(seed: int) -> dict:
        np.random.seed(seed)
        before = np.random.get_state()[1].tobytes()
        randomizer = unvaried.randomize(objects={"cube": MASS})
        randomizer.begin(0)
        assert np.random.get_state()[1].tobytes() == before
        return randomizer.sampled

    assert drawn(1) == drawn(2)
