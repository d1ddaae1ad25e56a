"""Give each reader 4 MB of its worst inputs, and print time and memory as a table.

``python tools/worst_inputs.py`` reads all, ``python tools/worst_inputs.py toml tree`` only those
whose name begins with one of these words. Each is read in a process of its own. Exits with 1 if one
takes more than `SECONDS` of processor time or `MEGABYTES`, or ends with an error that is none of
bt-manip's.
"""

import os
import resource
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("MUJOCO_GL", "disable")

from bt_manip.bt import read_tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import ModelObject
from bt_manip.exceptions import BtManipError
from bt_manip.models.hardened_xml import MAX_MODEL_ELEMENTS
from bt_manip.plugins import load_plugins
from bt_manip.record import read_report
from bt_manip.robots import read_description
from bt_manip.runner import known_behaviours, load_snapshot
from bt_manip.scenes import read_scene
from bt_manip.spatial import pose
from bt_manip.toml import MAX_TOML_BYTES
from bt_manip_recording import Recording

PARTS = load_plugins().parts
SIZE = 4 * 2**20  # [bytes]
SECONDS = 1.0  # [s] of processor time
MEGABYTES = 512.0
TIMEOUT = 10.0  # [s]

TREE = '<root BTCPP_format="4"><BehaviorTree ID="T">{}</BehaviorTree></root>'
URDF = '<robot name="r"><link name="base">{}</link></robot>'
MJCF = '<mujoco model="m"><worldbody><body name="b">{}</body></worldbody></mujoco>'
SDF = '<sdf version="1.9"><model name="m"><link name="l">{}</link></model></sdf>'
GEOM = '<geom type="sphere" size=".02"/>'
ATTRIBUTE = 'a@="" '
LAUGHS = "".join(f'<!ENTITY a{i} "' + (f"&a{i - 1};" * 10 if i else "ha") + '">' for i in range(10))


class Case(NamedTuple):
    """An input and its reader."""

    name: str
    suffix: str
    content: bytes
    read: Callable[[Path], object]


def main() -> None:
    """Print a row for each input."""
    wanted, bad = tuple(sys.argv[1:]), 0
    print("| input | MB | time [s] | memory [MB] | result |\n| --- | ---: | ---: | ---: | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for case in cases():
            if not wanted or case.name.startswith(wanted):
                seconds, megabytes, end = measured(case, Path(folder))
                failed = seconds > SECONDS or megabytes > MEGABYTES or end.startswith("!")
                bad += failed
                size = len(case.content) / 2**20
                row = f"| {case.name} | {size:.2f} | {seconds:.2f} | {megabytes:.0f} | {end} |"
                print(row + " **too much**" * failed, flush=True)
    sys.exit(1 if bad else 0)


def measured(case: Case, folder: Path) -> tuple[float, float, str]:
    """Return processor time [s], memory [MB] and result of reading an input in a process."""
    path, log = folder / f"input{case.suffix}", folder / "output"
    path.write_bytes(case.content)
    log.write_text("!ended without an answer")
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (int(TIMEOUT), int(TIMEOUT)))
        used, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
        try:
            case.read(path)
            end = "read"
        except (BtManipError, OSError) as error:
            end = str(error).replace(f"{folder}/", "").partition("\n")[0]
        except BaseException as error:
            end = f"!{type(error).__name__}: {error}"
        spent = time.process_time() - begin
        more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - used
        log.write_text(f"{spent}\n{more / 1024}\n{end[:80]}")
        os._exit(0)
    os.waitpid(child, 0)
    words = log.read_text(errors="replace").splitlines()
    if len(words) < 3:
        return TIMEOUT, 0.0, words[0]
    return float(words[0]), float(words[1]), words[2].replace("|", "\\|")


def check_tree(path: Path) -> None:
    """Read a tree document."""
    reading = read_tree(path, known_behaviours(PARTS))
    for problem in reading.problems:
        raise BtManipError(str(problem))


def read_model(path: Path) -> None:
    """Compile a model as the only object of a cell."""
    Cell().add(ModelObject(str(path)), pose((0.0, 0.0, 1.0)), name="x", overlap=1.0)


def read_recording(path: Path) -> None:
    """Read all messages of a recording."""
    for _ in Recording(path).messages():
        pass


def read_policy(path: Path) -> None:
    """Load a policy."""
    from bt_manip_policy.onnx_policy import OnnxPolicy

    OnnxPolicy(path)


def read_data_set(path: Path) -> None:
    """Read a folder of demonstrations with this manifest, and this file as its only episode."""
    from bt_manip_learn.demonstrations import read_demonstrations

    with tempfile.TemporaryDirectory() as folder:
        episode = path.suffix == ".h5"
        manifest = b'{"format": "bt-manip demonstrations", "version": 1}'
        (Path(folder) / "manifest.json").write_bytes(manifest if episode else path.read_bytes())
        if episode:
            (Path(folder) / "episode_000000.h5").write_bytes(path.read_bytes())
        list(read_demonstrations(folder))


def read_evaluation(path: Path) -> None:
    """Read a folder of results with this identity, or this file as its only part."""
    from bt_manip.evaluation import read_results

    with tempfile.TemporaryDirectory() as folder:
        name = "part-00000.parquet" if path.suffix == ".parquet" else "_evaluation.json"
        (Path(folder) / "_evaluation.json").write_text("{}")
        (Path(folder) / name).write_bytes(path.read_bytes())
        read_results(Path(folder))


def cases() -> Iterator[Case]:
    """Yield all inputs."""
    readers: Any
    for name, text in trees():
        yield Case(f"tree, {name}", ".xml", text.encode(), check_tree)
    readers = {"scene": lambda path: read_scene(path, PARTS), "robot": read_description}
    for kind, reader in readers.items():
        for name, text in tomls():
            yield Case(f"{kind}, {name}", ".toml", text.encode(), reader)
    for name, suffix, content in models():
        yield Case(f"model, {name}", suffix, content, read_model)
    readers = {
        "snapshot": load_snapshot,
        "report": read_report,
        "data set": read_data_set,
        "results": read_evaluation,
    }
    for kind, reader in readers.items():
        for name, content in documents():
            yield Case(f"{kind}, {name}", ".json", content, reader)
    for name, content in recordings():
        yield Case(f"recording, {name}", ".mcap", content, read_recording)
    for kind, suffix, head, reader in (
        ("data set", ".h5", b"\x89HDF\r\n\x1a\n", read_data_set),
        ("results", ".parquet", b"PAR1", read_evaluation),
    ):
        noise = head + os.urandom(SIZE) + head[:4]
        yield Case(f"{kind}, noise", suffix, noise, reader)
        yield Case(f"{kind}, zeros", suffix, head + bytes(SIZE) + head[:4], reader)
    for name, content in policies():
        yield Case(f"policy, {name}", ".onnx", content, read_policy)


def repeated(piece: str, size: int = SIZE) -> str:
    """Return a text repeated up to a size."""
    return piece * (size // len(piece))


def numbered(piece: str, size: int = SIZE) -> str:
    """Return a text with ``@`` replaced by a number, for all numbers up to a size."""
    parts, length = [], 0
    while length < size:
        parts.append(piece.replace("@", str(len(parts))))
        length += len(parts[-1])
    return "".join(parts)


def trees() -> Iterator[tuple[str, str]]:
    """Yield tree documents."""
    nested = repeated("<Inverter>") + "<AlwaysSuccess/>" + repeated("</Inverter>")
    yield "nested", TREE.format(nested)
    yield "wide", TREE.format(f"<Sequence>{repeated('<AlwaysSuccess/>')}</Sequence>")
    yield "unknown nodes", TREE.format(f"<Sequence>{numbered('<X@/>')}</Sequence>")
    yield "attributes", TREE.format("<AlwaysSuccess " + numbered(ATTRIBUTE) + "/>")
    yield "remapped ports", TREE.format('<SubTree ID="T" ' + numbered('a@="{b@}" ') + "/>")
    yield "a long name", TREE.format(f"<{repeated('a')}/>")
    yield "a long value", TREE.format(f'<Sleep msec="{repeated("9")}"/>')
    many = numbered('<BehaviorTree ID="T@"><AlwaysSuccess/></BehaviorTree>')
    yield "trees", f'<root BTCPP_format="4">{many}</root>'
    chain = numbered('<BehaviorTree ID="T@"><SubTree ID="T@1"/></BehaviorTree>')
    chained = f'<root BTCPP_format="4" main_tree_to_execute="T0">{chain}</root>'
    yield "sub-trees in a chain", chained
    yield "entities", f"<!DOCTYPE r [{LAUGHS}]>" + TREE.format("&a9;")
    yield "a comment", TREE.format(f"<!--{repeated('- ')}-->")
    yield "not closed", repeated("<a>")
    scripts = {
        "brackets": repeated("("),
        "operators": "a := 1" + repeated("+1"),
        "signs": "a := " + repeated("-") + "1",
        "statements": numbered("a@:=1;"),
        "a number": "a := " + repeated("9"),
        "a string": "a := '" + repeated("x"),
    }
    for name, script in scripts.items():
        yield f"script, {name}", TREE.format(f'<Script code="{script}"/>')
    goal = f'ID="T" _goal="{repeated("IsOn object=a support=b &amp;&amp; ")}"'
    yield "goal", TREE.format("<AlwaysSuccess/>").replace('ID="T"', goal)


def tomls() -> Iterator[tuple[str, str]]:
    """Yield TOML texts of 4 MB, and of the largest size that is read."""
    yield "4 MB of keys", numbered("k@ = 1\n")
    size = MAX_TOML_BYTES - 100
    of = f"{size / 1024:.0f} kB of "
    yield of + "a word", repeated("x", size)
    yield of + "digits", "x = " + repeated("9", size)
    yield of + "keys", numbered("k@ = 1\n", size)
    yield of + "tables", numbered("[t@]\na = 1\n", size)
    yield of + "objects", repeated("[[objects]]\n", size)
    yield of + "dotted keys", numbered("a.b@.c = 1\n", size)
    yield of + "a list", "x = [" + repeated("1,", size) + "]"
    yield of + "brackets", "x = " + repeated("[", size)
    yield of + "a string", 'x = "' + repeated("\\n", size) + '"'
    yield of + "an open string", 'x = """' + repeated('\\"', size)
    yield of + "comments", repeated("#\n", size)
    yield of + "dots", repeated("a .", size)
    yield of + "blanks", repeated(" ", size)


def models() -> Iterator[tuple[str, str, bytes]]:
    """Yield models: a name, the suffix and the content."""
    most = (MAX_MODEL_ELEMENTS - 3) * len(GEOM)
    yield "MJCF, the most geoms", ".xml", MJCF.format(repeated(GEOM, most)).encode()
    sphere = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    for kind, frame, link, geom in (
        ("MJCF", MJCF, "body", GEOM),
        ("URDF", URDF, "a", '<visual><geometry><sphere radius="1"/></geometry></visual>'),
        ("SDF", SDF, "a", f'<visual name="v@">{sphere}</visual>'),
    ):
        element = geom.split()[0].split(">")[0]
        bodies = {
            "wide": numbered(geom),
            "nested": repeated(f"<{link}>") + repeated(f"</{link}>"),
            "attributes": f"{element} {numbered(ATTRIBUTE)}/>",
            "entities": "&a9;",
            "numbers": f'<geom size="{repeated("1 ")}"/>',
        }
        for name, body in bodies.items():
            head = f"<!DOCTYPE r [{LAUGHS}]>" if name == "entities" else ""
            suffix = ".xml" if kind == "MJCF" else f".{kind.lower()}"
            yield f"{kind}, {name}", suffix, (head + frame.format(body)).encode()
    corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    yield "OBJ, vertices", ".obj", (numbered("v @ 1 2\n") + "f 1 2 3\n").encode()
    yield "OBJ, faces", ".obj", (corner + repeated("f 1 2 3\n")).encode()
    yield "OBJ, a polygon", ".obj", (corner + "f " + repeated("1 2 3 4 ")).encode()
    yield "OBJ, a number", ".obj", ("v " + repeated("9")).encode()
    yield "OBJ, objects", ".obj", (corner + numbered("o o@\nf 1 2 3\n")).encode()
    facet = struct.pack("<12fH", *(0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0), 0)
    count = SIZE // 50
    for name, claimed in (("facets", count), ("a false count", 2**32 - 1)):
        yield f"STL, {name}", ".stl", bytes(80) + struct.pack("<I", claimed) + facet * count
    text = b"solid x\n" + b"facet normal 0 0 1\nouter loop\n" * (SIZE // 31)
    yield "STL, text", ".stl", text


def documents() -> Iterator[tuple[str, bytes]]:
    """Yield JSON documents."""
    yield "brackets", b"[" * SIZE
    yield "objects", b'{"a":' * (SIZE // 5)
    yield "digits", b'{"version": ' + b"9" * SIZE + b"}"
    yield "keys", ("{" + numbered('"k@":1,') + '"z":1}').encode()
    yield "a string", b'{"version": "' + b"\\u00e9" * (SIZE // 6) + b'"}'
    yield "a list", b"[" + b"0," * (SIZE // 2) + b"0]"


def recordings() -> Iterator[tuple[str, bytes]]:
    """Yield MCAP files: records with a false length, chunks that expand, and many of them."""
    magic = b"\x89MCAP0\r\n"

    def record(kind: int, data: bytes) -> bytes:
        return struct.pack("<BQ", kind, len(data)) + data

    header = magic + record(1, struct.pack("<I", 0) * 2)
    yield "a false length", header + struct.pack("<BQ", 6, 2**62) + b"x" * SIZE
    yield "empty records", header + record(0x80, b"") * (SIZE // 9)
    yield "noise", header + os.urandom(SIZE)
    try:
        import zstandard

        bomb = zstandard.compress(bytes(2**30))
        chunk = struct.pack("<QQQI", 0, 0, 2**30, 0) + struct.pack("<I", 4) + b"zstd"
        yield "a chunk of 1 GB", header + record(6, chunk + struct.pack("<Q", len(bomb)) + bomb)
    except ImportError:
        pass
    channel = struct.pack("<HHI1sI4sI", 1, 0, 1, b"t", 4, b"json", 0)
    message = struct.pack("<HIQQ", 1, 0, 0, 0) + b"{}"
    yield "messages", header + record(4, channel) + record(5, message) * (SIZE // 33)


def policies() -> Iterator[tuple[str, bytes]]:
    """Yield files that are no ONNX models, or nested ones."""
    yield "noise", b"\x08" + os.urandom(SIZE)
    field = b""
    for _ in range(20000):  # a graph in an attribute of a node of a graph
        head, length = b"", len(field)
        while length > 127:
            head, length = head + bytes([length & 127 | 128]), length >> 7
        field = b"\x3a" + head + bytes([length]) + field
        if len(field) > SIZE:
            break
    yield "nested", field
    yield "empty fields", b"\x3a\x00" * (SIZE // 2)


if __name__ == "__main__":
    main()
