"""Rotation, scaling, mirror image: programs in, machine positions out; laws of the geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.decoder.nct.transformations import Scaled, Transformations, Turned
from runtime.diagnostics.catalogue import nct, nct_offsets
from tests.cnc.decoder.nct.programs import decode, found
from tests.cnc.decoder.nct.test_offsets import ends, numbers


def about(centre: tuple[float, float], angle: float, point: tuple[float, float]) -> list[float]:
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y = point[0] - centre[0], point[1] - centre[1]
    return [centre[0] + c * x - s * y, centre[1] + s * x + c * y]


def in_plane(text: str) -> list[list[float]]:
    return [end[:2] for end in ends(text)]


# ---------------------------------------------------------------------------------------------------- rotation


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
@pytest.mark.parametrize("first", ["G1 X60 Y20 F150", "G91 X60 Y20 F150"])
def test_the_rotation_of_the_manual(first: str) -> None:
    """Both forms of N3 mean the same: what was programmed last are the numbers 0, 0, not their image."""
    text = f"N1 G17 G90 G0 X0 Y0\nN2 G68 X90 Y60 R60\nN3 {first}\nN4 G91 X80\nN5 G3 Y60 R100\n"
    text += "N6 G1 X-80\nN7 Y-60\nN8 G69 G90 X0 Y0"
    run = decode(text)
    assert run.problem is None
    points = [(60, 20), (140, 20), (140, 80), (60, 80), (60, 20)]
    expected: list[list[float]] = [[0, 0], *(about((90, 60), 60, p) for p in points), [0, 0]]
    assert np.allclose([end[:2] for end in run.ends], expected)
    (arc,) = run.of_type("arc")
    assert arc["radius"] == pytest.approx(100)
    centre = (140 - math.sqrt(100**2 - 30**2), 50)
    assert np.allclose(list(arc["centre"].values()), about((90, 60), 60, centre))  # type: ignore[attr-defined]


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_a_missing_coordinate_of_the_centre_is_that_of_the_position() -> None:
    expected = about((10, 20), 90, (15, 20))
    assert np.allclose(in_plane("G0 X10 Y20\nG68 R90\nX15")[-1], expected)
    assert np.allclose(in_plane("G0 X10 Y20\nG68 X10 R90\nX15")[-1], expected)
    assert np.allclose(in_plane("G0 X10 Y20\nG91 G68 X5 YI-5 R90\nG90 X15 Y20")[-1], about((15, 15), 90, (15, 20)))


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_an_incremental_angle_is_added() -> None:
    for second in ("G91 G68 XI0 YI0 R15", "G68 XI0 YI0 RI15"):
        turned = in_plane(f"G68 X0 Y0 R30\n{second}\nG90 G0 X10 Y0")
        assert np.allclose(turned[-1], about((0, 0), 45, (10, 0)))
    assert np.allclose(in_plane("G68 X0 Y0 R30\nG68 X0 Y0 R-15\nG0 X10 Y0")[-1], about((0, 0), -15, (10, 0)))


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_angles_count_in_thousandths() -> None:
    assert np.allclose(in_plane("G68 X0 Y0 R30.00049\nG0 X1000 Y0")[-1], about((0, 0), 30, (1000, 0)), atol=1e-6)


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_it_acts_in_the_selected_plane() -> None:
    (end,) = ends("G18 G68 Z0 X0 R90\nG0 Z10 X0 Y3")
    assert np.allclose(end, [10, 3, 0])
    (end,) = ends("G19 G68 Y0 Z0 R90\nG0 Y10 Z0 X3")
    assert np.allclose(end, [3, 0, 10])


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_switched_on_and_off_nothing_moves() -> None:
    run = decode("G0 X10 Y0\nG68 X0 Y0 R90\nG69\nG91 X1")
    assert run.ends == [[10, 0, 0], [11, 0, 0]]
    moved = decode("G68 X0 Y0 R90\nG0 X10 Y0\nG69")
    assert np.allclose(numbers(moved), [0, 10, 0])


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
def test_a_plane_axis_alone_takes_the_other_one_along() -> None:
    assert np.allclose(in_plane("G0 X10 Y0\nG68 X0 Y0 R90\nX5")[-1], [0, 5])


@pytest.mark.spec("nct.trafo.rotation-g68-g69")
@pytest.mark.parametrize(
    ("text", "entry", "line", "column"),
    [
        ("G68 X0 Y0", nct_offsets.VALUE_MISSING, 1, 1),
        ("G68 X0 Z5 R30", nct.WORD_WITHOUT_MEANING, 1, 8),
        ("G68 X0 Y0 R30\nG18", nct_offsets.PLANE_TURNED, 2, 1),
    ],
)
def test_errors_of_the_rotation(text: str, entry: object, line: int, column: int) -> None:
    assert found(text) == (entry, line, column)


# ---------------------------------------------------------------------------------------------------- scaling


@pytest.mark.spec("nct.trafo.scaling-g50-g51")
@pytest.mark.parametrize("first", ["G1 X30 Y100 F150", "G91 X30 Y100 F150"])
def test_the_scaling_of_the_manual(first: str) -> None:
    text = f"N1 G90 G0 X0 Y0\nN2 G51 X60 Y140 P0.5\nN3 {first}\nN4 G91 X100\nN5 G3 Y60 R100\n"
    text += "N6 G1 X-100\nN7 Y-60\nN8 G50 G90 X0 Y0"
    run = decode(text)
    assert run.problem is None
    points = [(30, 100), (130, 100), (130, 160), (30, 160), (30, 100)]
    expected: list[list[float]] = [[0, 0], *([60 + (x - 60) / 2, 140 + (y - 140) / 2] for x, y in points), [0, 0]]
    assert np.allclose([end[:2] for end in run.ends], expected)
    (arc,) = run.of_type("arc")
    assert arc["radius"] == pytest.approx(50)


@pytest.mark.spec("nct.trafo.scaling-g50-g51")
def test_an_axis_that_is_not_programmed_does_not_move() -> None:
    assert ends("G0 X10 Y20 Z30\nG51 X0 Y0 Z0 P2\nX5\nG91 Z1") == [[10, 20, 30], [10, 20, 30], [10, 20, 62]]


@pytest.mark.spec("nct.trafo.scaling-g50-g51")
def test_centres_of_arcs_are_scaled_too() -> None:
    (arc,) = decode("G51 X0 Y0 Z0 P3\nG3 X10 Y0 I5 F100").of_type("arc")
    assert list(arc["centre"].values()) == [15, 0]  # type: ignore[attr-defined]
    assert arc["radius"] == 15


@pytest.mark.spec("nct.trafo.scaling-g50-g51")
@pytest.mark.parametrize(("text", "column"), [("G51 X1", 1), ("G51 X1 P0", 8), ("G51 X1 P-2", 8)])
def test_errors_of_the_scaling(text: str, column: int) -> None:
    assert found(text) == (nct.FAULTY_P, 1, column)


# ---------------------------------------------------------------------------------------------------- mirror image

SUB = "O0101\nN1 G90 G0 X180 Y120 F120\nN2 G1 X240\nN3 Y160\nN4 G3 X180 Y120 R80\nN5 M99"


@pytest.mark.spec("nct.trafo.mirror-g50-1-g51-1")
def test_the_mirror_images_of_the_manual() -> None:
    main = "N1 G90\nN2 M98 P101\nN3 G51.1 X140\nN4 M98 P101\nN5 G51.1 Y100\nN6 M98 P101\nN7 G50.1 X0\n"
    main += "N8 M98 P101\nN9 G50.1 Y0\nM30"
    run = decode(main, files={"O0101.nc": SUB})
    assert run.problem is None
    points = np.array([(180, 120), (240, 120), (240, 160), (180, 120)])
    mirrored = [points, (280, 0) + points * (-1, 1), (280, 200) - points, (0, 200) + points * (1, -1)]
    assert np.allclose([end[:2] for end in run.ends], np.vstack(mirrored))
    senses = [float(arc["angle"]) > 0 for arc in run.of_type("arc")]  # type: ignore[arg-type]
    assert senses == [True, False, True, False]


@pytest.mark.spec("nct.trafo.mirror-g50-1-g51-1")
def test_a_mirrored_rotation_turns_the_other_way() -> None:
    assert np.allclose(in_plane("G51.1 X0\nG68 X0 Y0 R30\nG0 X10 Y0")[-1], [-10 * math.cos(math.radians(30)), 5])


@pytest.mark.spec("nct.trafo.mirror-g50-1-g51-1")
def test_incremental_mirror_lines() -> None:
    assert in_plane("G0 X10\nG91 G51.1 X5\nG90 X20")[-1] == [10, 0]


@pytest.mark.spec("nct.trafo.mirror-g50-1-g51-1", "nct.trafo.nesting")
@pytest.mark.parametrize("inside", ["G51 X0 Y0 P2", "G68 X0 Y0 R5"])
@pytest.mark.parametrize("mirror", ["G51.1 X0", "G50.1 X0"])
def test_mirrors_stand_outside(inside: str, mirror: str) -> None:
    assert found(f"{inside}\nN2 {mirror}") == (nct_offsets.MIRROR_INSIDE, 2, 4)


@pytest.mark.spec("nct.trafo.mirror-g50-1-g51-1")
def test_a_mirror_needs_an_axis() -> None:
    assert found("G51.1") == (nct_offsets.AXIS_WANTED, 1, 1)


# ---------------------------------------------------------------------------------------------------- nesting


@pytest.mark.spec("nct.trafo.nesting")
def test_what_comes_first_acts_on_the_centre_of_the_second() -> None:
    def scaled(point: tuple[float, float]) -> tuple[float, float]:
        return 130 + (point[0] - 130) / 2, 70 + (point[1] - 70) / 2

    rotated_first = in_plane("G68 X80 Y40 R60\nG51 X130 Y70 P0.5\nG0 X180 Y40\nG50\nG69")
    assert np.allclose(rotated_first[-1], about((80, 40), 60, scaled((180, 40))))
    scaled_first = in_plane("G51 X130 Y70 P0.5\nG68 X80 Y40 R60\nG0 X180 Y40\nG69\nG50")
    x, y = about((80, 40), 60, (180, 40))
    assert np.allclose(scaled_first[-1], scaled((x, y)))


@pytest.mark.spec("nct.trafo.nesting")
@pytest.mark.parametrize("text", ["G68 X0 Y0 R5\nG51 X0 Y0 P2\nG69", "G51 X0 Y0 P2\nG68 X0 Y0 R5\nG50"])
def test_they_are_switched_off_in_reverse(text: str) -> None:
    assert found(text) == (nct_offsets.NOT_NESTED, 3, 1)


coordinates = st.floats(-500, 500)
planes = st.sampled_from([(0, 1), (2, 0), (1, 2)])


@st.composite
def chains(draw: st.DrawFn) -> Transformations:
    made = Transformations()
    for axis in draw(st.sets(st.integers(0, 3))):
        made.mirrors[axis] = draw(coordinates)
    steps = [
        Turned(
            draw(st.sampled_from([(0, 1), (2, 0), (1, 2)])),
            draw(st.floats(-360, 360)),
            (draw(coordinates), draw(coordinates)),
        ),
        Scaled(draw(st.floats(0.1, 10)), tuple(draw(coordinates) for _ in range(4)), (0, 1, 2)),
    ]
    made.nested = draw(st.lists(st.sampled_from(steps), unique=True, max_size=2))
    return made


@settings(deadline=None, derandomize=True)
@given(chains(), st.lists(coordinates, min_size=4, max_size=4))
def test_source_undoes_image(chain: Transformations, point: list[float]) -> None:
    assert np.allclose(chain.source(chain.image(point)), point, atol=1e-6)


@settings(deadline=None, derandomize=True)
@given(chains(), st.lists(coordinates, min_size=4, max_size=4), st.lists(coordinates, min_size=4, max_size=4))
def test_lengths_in_space_scale_alike_in_all_directions(chain: Transformations, a: list[float], b: list[float]) -> None:
    factor = 1.0 if chain.scaled is None else chain.scaled.factor
    there = np.array(chain.image(a))[:3] - np.array(chain.image(b))[:3]
    assert np.linalg.norm(there) == pytest.approx(factor * np.linalg.norm(np.array(a)[:3] - np.array(b)[:3]), abs=1e-6)
