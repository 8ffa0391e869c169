"""The demo, on the small scene: everything it promises to write is there and agrees."""

import dataclasses
import json

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from active_perceiver.cli.demo_run import SETTINGS, run_demo
from active_perceiver.errors import UserError
from active_perceiver.scenes import open_scene
from active_perceiver.utils.files import OutputExistsError

pytestmark = pytest.mark.xdist_group("demo")


@pytest.fixture(scope="module")
def demo(settings, tmp_path_factory):
    out = tmp_path_factory.mktemp("demo") / "demo"
    run_demo(out, dataclasses.replace(settings, targets=("ball0", "ball2")))
    return out


def test_the_result_holds_what_the_readme_quotes(demo):
    result = json.loads((demo / "result.json").read_text())
    assert result["command"] == "demo"
    assert set(result["recogniser"]) == {"matching", "pooled"}
    for kind in result["recogniser"].values():
        assert 0 <= kind["metrics"]["seen pictures"]["auroc"] <= 1
    assert [search["target"] for search in result["searches"]] == ["ball0", "ball2"]
    assert {"features", "recogniser", "policy", "demo"} <= set(result["seconds"])


def test_each_search_has_a_video_and_pictures(demo):
    for name in ("ball0", "ball2"):
        search = json.loads((demo / name / "search.json").read_text())
        reader = imageio_ffmpeg.read_frames(str(demo / name / "search.mp4"))
        meta = next(reader)
        frames = sum(1 for _ in reader)
        assert meta["size"] == (1120, 640)
        assert frames >= search["actions"] + 1
        assert np.asarray(Image.open(demo / name / "path.png")).std() > 5
        assert Image.open(demo / name / "filmstrip.png").width > 1000


def test_the_report_is_one_file_with_everything_in_it(demo):
    text = (demo / "report.html").read_text()
    assert text.count("<video") == 2
    assert text.count("data:video/mp4;base64,") == 2
    assert "http://" not in text.replace("http://www.w3.org", "")
    assert "found" in text


def test_a_demo_that_is_there_is_not_overwritten(demo, settings):
    with pytest.raises(OutputExistsError, match="--force"):
        run_demo(demo, settings)


def test_a_demo_does_not_go_on_with_other_settings(demo, settings):
    other = dataclasses.replace(settings, targets=("ball0", "ball2"), seed=5)
    with pytest.raises(UserError, match="other settings"):
        run_demo(demo, other, resume=True)


def test_the_real_demo_searches_the_four_targets_of_record():
    assert SETTINGS.targets == ("mug", "plate", "bread", "apple")
    assert set(SETTINGS.targets) <= set(open_scene(SETTINGS.scenes[0]).target_names)
