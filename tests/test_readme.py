"""The figures in the README are those of the committed result."""

import json
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
RESULT = json.loads((ROOT / "benchmarks" / "demo.json").read_text())


def row_of(name: str) -> list[str]:
    rows = [line for line in README.splitlines() if line.startswith(f"| {name} |")]
    assert len(rows) == 1, f"the README has {len(rows)} rows for {name}"
    return [cell.strip() for cell in rows[0].strip("|").split("|")][1:]


@pytest.mark.parametrize("index", range(4))
def test_the_figures_of_each_target(index):
    result = RESULT["per_target"][index]
    seen, unseen = (RESULT["own_word"][key]["per_target"][index] for key in ("pictures_seen", "pictures_unseen"))
    assert row_of(result["target"]) == [
        f"{100 * result['success']:.0f} %",
        f"{result['mean_steps']:.2f}",
        f"{result['shortest_mean']:.2f}",
        f"{result['ratio']:.3f}",
        f"{100 * seen['true_found']:.0f} %",
        f"{100 * unseen['true_found']:.0f} %, {unseen['mean_steps']:.1f} actions",
    ]


@pytest.mark.parametrize("kind", ["matching", "pooled"])
@pytest.mark.parametrize("pictures", ["seen pictures", "unseen pictures"])
def test_the_figures_of_the_recognisers(kind, pictures):
    metrics = RESULT["recogniser"][kind]["metrics"][pictures]
    assert row_of(f"{kind}, {pictures}") == [f"{metrics[name]:.3f}" for name in ("auroc", "ap50", "mean_iou")]


def test_how_many_of_the_founds_were_false():
    assert RESULT["own_word"]["pictures_seen"]["overall"]["false_found"] == 0
    false = RESULT["own_word"]["pictures_unseen"]["overall"]["false_found"]
    assert f"{100 * false:.1f} % of\nthe searches with pictures never seen" in README


def test_the_times():
    for name in ("policy", "recogniser", "demo"):
        assert f"{RESULT['seconds'][name]:.0f} s" in README


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("one kitchen, 4 objects", "kitchen_1"),
        ("four rooms, 16 objects", "four_rooms"),
        ("conference room, 6 actions", "conference_room"),
    ],
)
def test_the_figures_beside_the_papers(label, name):
    result = json.loads((ROOT / "benchmarks" / "scenes" / f"{name}.json").read_text())
    overall, word = result["overall"], result["own_word"]["pictures_unseen"]["overall"]
    assert row_of(label)[2:] == [
        f"{100 * overall['success']:.0f} %, {overall['mean_steps']:.1f} actions",
        f"{overall['ratio']:.3f}",
        f"{100 * word['true_found']:.1f} %, {100 * word['false_found']:.1f} %",
    ]


def test_the_worst_policies_and_the_time_of_an_action():
    summary = json.loads((ROOT / "benchmarks" / "policies.json").read_text())["summary"]
    rows = [row for row in summary if row["learner"] == "mirror-descent"]
    for group in ([row for row in rows if row["setup"] != "4 scenes"], [rows[-1]]):
        ratio, seconds = (max(row[name]["worst"] for row in group) for name in ("ratio", "seconds"))
        assert all(row["success"] == 1.0 for row in group)
        assert f"{ratio:.3f} x" in README
        assert f"{seconds:.0f} s" in README
    (action,) = [
        one
        for one in json.loads((ROOT / "benchmarks" / "act.json").read_text())["actions"]
        if one["backbone"] == "efficientnet_lite0" and one["threads"] == 1
    ]
    assert 9.0 <= action["ms"]["whole"]["median"] <= 11.0


def test_what_the_project_promises_of_its_demo():
    """The numbers this project set out to reach (policy, recogniser and own word), as committed."""
    assert RESULT["overall"]["success"] == 1.0
    assert RESULT["overall"]["ratio"] <= 1.02
    assert RESULT["seconds"]["policy"] <= 15
    assert RESULT["seconds"]["recogniser"] <= 240
    assert RESULT["seconds"]["demo"] <= 360
    for pictures, auroc, ap50 in (("seen pictures", 0.997, 0.93), ("unseen pictures", 0.994, 0.91)):
        metrics = RESULT["recogniser"]["matching"]["metrics"][pictures]
        assert metrics["auroc"] >= auroc
        assert metrics["ap50"] >= ap50
        assert metrics["false_positive_rate"] < 0.01
    for pictures in ("pictures_seen", "pictures_unseen"):
        for result in RESULT["own_word"][pictures]["per_target"]:
            assert result["true_found"] >= 0.95
            assert result["false_found"] <= 0.02
