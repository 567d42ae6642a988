"""What is refused is named, with what was expected; what means the same gives the same."""

import numpy as np
import pytest

import enact_motion
from enact_motion import Scene, SceneError, Take, TakeError

N = 30


def arrays():
    t = np.linspace(0, 0.3, N)
    position = np.stack([t, -t, 1 - 4.9 * t**2], axis=1)
    quaternion = np.stack([np.cos(t), np.sin(t), 0 * t, 0 * t], axis=1)
    return t, position, quaternion


def bytes_of(t, position, quaternion, order="wxyz"):
    scene = Scene.new("die", stamps="physical")
    return Take(scene).poses("die", t, position, quaternion, order=order).to_bytes()


def refused(error, match, *changes, order="wxyz", track="die"):
    t, position, quaternion = arrays()
    arguments = {"t": t, "position": position, "quaternion": quaternion}
    for name, value in changes:
        arguments[name] = value(arguments[name])
    with pytest.raises(error, match=match):
        Take(Scene.new("die")).poses(track, **arguments, order=order)


def put(at, value):
    def change(array):
        array = array.copy()
        array[at] = value
        return array

    return change


def test_arguments_are_named_with_what_was_expected():
    refused(ValueError, r"^t: shape \(30, 1\), expected \(n,\)", ("t", lambda t: t[:, None]))
    refused(ValueError, r"^position: shape \(29, 3\), expected \(30, 3\)", ("position", lambda x: x[1:]))
    refused(ValueError, r"^position: shape \(3, 30\), expected \(30, 3\)", ("position", lambda x: x.T))
    refused(ValueError, r"^quaternion: shape \(30, 3\), expected \(30, 4\)", ("quaternion", lambda q: q[:, 1:]))
    refused(ValueError, r"^position\[7\]: .*finite", ("position", put((7, 1), np.nan)))
    refused(ValueError, r"^t\[2\]: inf, expected finite", ("t", put(2, np.inf)))
    refused(ValueError, r"^quaternion\[4\]: all zero", ("quaternion", put(4, 0.0)))
    refused(ValueError, r"^t\[5\]: .* after .*, expected increasing", ("t", put(5, 0.0)))
    refused(ValueError, r"^t\[5\]: .* after .*, expected increasing", ("t", lambda t: np.where(t == t[5], t[4], t)))
    refused(ValueError, r"^t: -0.1 to .*, expected seconds, not negative", ("t", lambda t: t - 0.1))
    refused(ValueError, r"^order: None, expected 'wxyz' or 'xyzw'", order=None)
    refused(ValueError, r"^order: 'wzyx', expected", order="wzyx")
    refused(ValueError, r"^quaternion: None, expected \(30, 4\): the track sees a pose", ("quaternion", lambda q: None))
    refused(ValueError, r"^position: .*, expected numbers of shape", ("position", lambda x: [["a", "b", "c"]] * N))
    refused(KeyError, r"track: no 'dye' in the scene, expected one of die", track="dye")


def test_marks_are_of_events_and_within_time():
    take = Take(Scene.new("die", bounces=3))
    for event in ["landing", "bounce 2", None]:
        take.mark(event, 0.1)
    with pytest.raises(KeyError, match="no 'bonce'"):
        take.mark("bonce", 0.1)
    for t in [-1, float("nan")]:
        with pytest.raises(ValueError, match="^t: "):
            take.mark("landing", t)


def test_lists_narrow_floats_strides_and_orders_give_the_same_take():
    t, position, quaternion = arrays()
    expected = bytes_of(t, position, quaternion)
    assert bytes_of(t.tolist(), position.tolist(), quaternion.tolist()) == expected
    assert bytes_of(t, np.asfortranarray(position), np.repeat(quaternion, 2, axis=0)[::2]) == expected
    assert bytes_of(t, position[::-1][::-1], np.roll(quaternion, -1, axis=1), order="xyzw") == expected
    assert bytes_of(t, position, -quaternion) != expected
    narrow = [array.astype(np.float32) for array in (t, position, quaternion)]
    assert bytes_of(*narrow) == bytes_of(*(array.astype(np.float64) for array in narrow))


def test_a_rotation_of_scipy_needs_no_order():
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    t, position, quaternion = arrays()
    of = rotation.from_quat(np.roll(quaternion, -1, axis=1))
    xyzw = of.as_quat()
    assert bytes_of(t, position, of, order=None) == bytes_of(t, position, xyzw, order="xyzw")


def test_scenes_are_refused_with_line_and_column(tmp_path):
    with pytest.raises(SceneError) as refused:
        Scene.from_toml('name = "x"\n\n  gravity = 3\n')
    assert (refused.value.line, refused.value.column, refused.value.file) == (3, 3, None)
    path = tmp_path / "scene.toml"
    path.write_text("name = 3\n")
    with pytest.raises(SceneError) as refused:
        Scene.from_file(path)
    assert (refused.value.line, refused.value.file) == (1, str(path))
    assert str(refused.value).startswith(f"{path}:1:8: ")
    with pytest.raises(FileNotFoundError):
        Scene.from_file(tmp_path / "none.toml")


def test_recordings_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="none.mcap"):
        enact_motion.read(tmp_path / "none.mcap")
    with pytest.raises(TakeError, match="take.mcap"):
        enact_motion.read(b"\x89MCAP")
    with pytest.raises(TakeError, match="is a folder"):
        enact_motion.read(tmp_path)


def test_a_take_of_which_no_estimate_is_possible_is_refused():
    t, position, quaternion = arrays()
    take = Take(Scene.new("die", stamps="physical"))
    with pytest.raises(TakeError):
        take.estimate()
    take.poses("die", t[:2], position[:2], quaternion[:2], order="wxyz")
    with pytest.raises(TakeError) as refused:
        take.estimate()
    assert refused.value.message and isinstance(refused.value.diagnoses, tuple)


def test_what_is_made_does_not_change(recordings):
    estimate = enact_motion.read(recordings["pencil_tip"]).estimate()
    with pytest.raises(AttributeError):
        estimate.verdict = "physical"
    with pytest.raises(AttributeError):
        estimate.take.scene.name = "x"
    with pytest.raises(AttributeError):
        estimate.events[0].time = 0
    with pytest.raises(ValueError, match="read-only"):
        estimate.sample(60).position[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        estimate.time_map["pencil"].acted[0] = 0
    estimate.report["verdict"] = "failed"
    assert estimate.report["verdict"] == "physical"
    with pytest.raises(ValueError, match="was read"):
        estimate.take.mark("bounce", 0.1)
