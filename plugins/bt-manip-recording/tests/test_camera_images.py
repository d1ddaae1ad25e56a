"""Images in a recording are those of its cameras."""

import json

import av
import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from mcap.reader import make_reader

from bt_manip.bt import Sleep
from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.exceptions import BtManipError
from bt_manip_recording import McapRecorder


def test_images_of_cameras_are_recorded_at_their_rate(opengl, make_run, tmp_path):
    path, cameras = tmp_path / "run.mcap", "overview,panda/wrist"
    recorder = McapRecorder(path, cameras=cameras, image_size="64x48", image_fps=25.0)
    run = make_run(Sleep("rest", msec=100))
    run.execute([recorder])
    shown = []
    for name in cameras.split(","):
        with path.open("rb") as file:
            found = list(make_reader(file).iter_messages(f"/images/{name}"))
        assert [message.log_time / 1e9 for _, _, message in found] == [0.0, 0.04, 0.08]
        for schema, _, message in found:
            image = CompressedImage.FromString(message.data)
            assert (schema.name, image.format) == ("foxglove.CompressedImage", "jpeg")
            assert image.timestamp.ToNanoseconds() == message.log_time
        (frame,) = av.CodecContext.create("mjpeg", "r").decode(av.Packet(image.data))
        shown.append(frame.to_ndarray(format="rgb24").astype(int))
        renderer = FrameRenderer(run.station.cell.model, 64, 48, shadow_size=0, samples=0)
        number = camera_number(renderer.model, name)
        expected = renderer.frame(run.station.cell.data, number).astype(int)
        renderer.close()
        assert np.abs(shown[-1] - expected).mean() < 5.0
    assert np.abs(shown[1] - shown[0]).mean() > 20.0
    layout = json.loads(path.with_suffix(".layout.json").read_text())
    images = [panel for panel in layout["configById"] if panel.startswith("Image!")]
    assert images == ["Image!/images/overview", "Image!/images/panda/wrist"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cameras": "overview,panda/wirst"}, "camera 'panda/wirst'; did you mean 'panda/wrist'?"),
        ({"cameras": "overview", "image_fps": 0.0}, "image_fps is above 0, got 0"),
        ({"cameras": "overview", "image_size": "64"}, "size is WIDTHxHEIGHT"),
    ],
)
def test_impossible_images_are_found_before_the_run(make_run, tmp_path, options, message):
    with pytest.raises(BtManipError) as error:
        make_run(Sleep(msec=20)).execute([McapRecorder(tmp_path / "run.mcap", **options)])
    assert message in str(error.value)
    assert not list(tmp_path.iterdir())
