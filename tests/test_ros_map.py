"""ROS maps as worlds."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from slam.errors import ScenarioError
from slam.scenario.file import dump_scenario, load_scenario
from slam.scenario.ros_map import RosMap, merge_cells
from slam.scenario.solids import clearance

HEADER = """\
image: {image}
resolution: 0.5
origin: [1.0, 2.0, {yaw}]
negate: {negate}
occupied_thresh: 0.65
free_thresh: 0.2
"""
PICTURE = np.array([[255, 255, 0], [255, 205, 0], [0, 100, 255]], np.uint8)  # the lowest row last; 100 is too bright


def write_map(folder: Path, yaw: float = 0.0, negate: int = 0, plain: bool = False) -> Path:
    picture = 255 - PICTURE if negate else PICTURE
    head = f"{'P2' if plain else 'P5'}\n# made by a test\n3 3\n255\n".encode()
    body = " ".join(map(str, picture.ravel())).encode() if plain else picture.tobytes()
    (folder / "map.pgm").write_bytes(head + body)
    path = folder / "map.yaml"
    path.write_text(HEADER.format(image="map.pgm", yaw=yaw, negate=negate))
    return path


@given(arrays(np.bool_, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_the_rectangles_cover_the_occupied_cells_and_no_other(occupied: Any) -> None:
    covered = np.zeros_like(occupied)
    for row, column, rows, columns in merge_cells(occupied):
        covered[row : row + rows, column : column + columns] = True
    assert (covered == occupied).all()


def test_few_rectangles_cover_the_cells() -> None:
    rooms = np.zeros((1000, 1000), np.bool_)
    rooms[::100] = rooms[:, ::100] = rooms[-1] = rooms[:, -1] = True
    assert len(merge_cells(rooms)) == 22


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("negate", [0, 1])
def test_dark_cells_are_placed_by_the_header(plain: bool, negate: int, tmp_path: Path) -> None:
    prisms = RosMap(file=str(write_map(tmp_path, negate=negate, plain=plain)), height=1.5).prisms()
    x, y = np.meshgrid(1.25 + 0.5 * np.arange(3), 2.25 + 0.5 * np.arange(3))
    inside = clearance(np.column_stack([x.ravel(), y.ravel()]), [prism.footprint for prism in prisms]) == 0.0
    assert (inside.reshape(3, 3) == (PICTURE[::-1] == 0)).all()
    assert {(prism.bottom, prism.top) for prism in prisms} == {(0.0, 1.5)}


def test_the_origin_may_be_turned(tmp_path: Path) -> None:
    footprints = [prism.footprint for prism in RosMap(file=str(write_map(tmp_path, yaw=np.pi / 2))).prisms()]
    assert min(corners[:, 0].min() for corners in footprints) == pytest.approx(1.0 - 1.5)
    assert clearance(np.array([[0.75, 2.25]]), footprints)[0] == 0.0  # the lower left cell is now the lower right one


def test_deep_and_coloured_images_are_read(tmp_path: Path) -> None:
    path = write_map(tmp_path)
    expected = len(RosMap(file=str(path)).prisms())
    for name, picture in [
        ("deep.png", Image.fromarray(PICTURE.astype(np.uint16) * 257)),
        ("colour.png", Image.fromarray(PICTURE).convert("RGB")),
    ]:
        picture.save(tmp_path / name)
        path.write_text(HEADER.format(image=name, yaw=0, negate=0) + "# changed\n" * len(name))
        assert len(RosMap(file=str(path)).prisms()) == expected


def test_a_path_starts_at_the_scenario_file(tmp_path: Path) -> None:
    write_map(tmp_path)
    path = tmp_path / "here.yaml"
    path.write_text("world: {map: {file: map.yaml}}")
    scenario = load_scenario(path)
    copy = tmp_path / "runs" / "config.yaml"
    copy.parent.mkdir()
    copy.write_text(dump_scenario(scenario))
    assert load_scenario(copy) == scenario


@pytest.mark.parametrize(
    ("header", "complaint"),
    [
        (None, "map.yaml: No such file or directory"),
        (
            "image: map.pgm\nresolution: -1\norigin: [0, 0, 0]\n",
            "map.yaml: resolution: expected a number greater",
        ),
        ("image: map.pgm\norigin: [0, 0, 0]\n", "map.yaml: resolution: this key is missing"),
        ("image: map.pgm\nresolution: 1\norigin: [0, 0, 0]\nmode: raw\n", "map.yaml: mode: expected 'trinary'"),
        ("image: none.pgm\nresolution: 1\norigin: [0, 0, 0]\n", "none.pgm: No such file or directory"),
        ("image: map.yaml\nresolution: 1\norigin: [0, 0, 0]\n", "map.yaml: not an image"),
        ("image: [", "map.yaml:1: not valid YAML: a value is missing"),
        (
            "just words",
            "map.yaml: the header of a ROS map: expected a section with keys such as image",
        ),
    ],
)
def test_a_bad_map_is_named(header: str | None, complaint: str, tmp_path: Path) -> None:
    write_map(tmp_path)
    (tmp_path / "map.yaml").unlink() if header is None else (tmp_path / "map.yaml").write_text(header)
    path = tmp_path / "here.yaml"
    path.write_text("world:\n  map:\n    file: map.yaml\n")
    with pytest.raises(ScenarioError, match=r"here\.yaml:2: world\.map: .*" + re.escape(complaint)) as error:
        load_scenario(path)
    assert "\n" not in str(error.value)
