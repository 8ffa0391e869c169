"""What agents reach, from the result files of `demo`, `train` and `benchmark`: one small function for each block."""

from __future__ import annotations

from typing import Any

from docs.generate.markdown import percent, result, table, true_false
from docs.generate.package import BENCHMARK_TABLES

_SETUPS = {
    "one kitchen, 4 objects": ("scenes/kitchen_1", "four_objects"),
    "four rooms, 16 objects": ("scenes/four_rooms", "sixteen_objects"),
    "conference room, 4 objects, 6 actions": ("scenes/conference_room", "conference_room"),
}
"""Label -> the result file of our agent, and what `reproduce` calls the setup."""


def benchmark_table(name: str) -> str:
    """What `benchmark NAME` printed of its committed result."""
    return f"```\n{BENCHMARK_TABLES[name](result(name))}\n```"


def beside_the_paper() -> str:
    """Our agents, and the paper's in its own rooms."""
    head = (
        "", "success", "actions", "x the fewest", "found: true, false", "paper, high exploration",
        "paper, low exploration",
    )  # fmt: skip
    rows = []
    for label, (name, setup) in _SETUPS.items():
        ours = result(name)
        overall, word = ours["overall"], ours["stop_evaluation"]["pictures_unseen"]["overall"]
        figures = (percent(overall["success"], 0), f"{overall['mean_steps']:.1f}", f"{overall['ratio']:.3f}")
        rows.append((label, *figures, true_false(word), *_paper(setup)))
    return table(head, rows)


def _paper(setup: str) -> list[str]:
    """Success and actions that the paper reports, with high and with low exploration."""
    figures = {row["method"]: row["paper"] for row in result("reproduction/table1")["rows"] if row["setup"] == setup}
    both = [figures[method] for method in ("record_high", "record_low")]
    return [f"{100 * one['success']:g} %, {one['mean_steps']:.0f} actions" for one in both]


def demo() -> str:
    """The demo's targets, and how long it took."""
    body = result("demo")
    seen, unseen = (body["stop_evaluation"][f"pictures_{kind}"] for kind in ("seen", "unseen"))
    head = (
        "target", "success", "actions", "fewest possible", "x the fewest", "found: true, false",
        "found: true, false, with a picture never seen", "actions",
    )  # fmt: skip
    rows = []
    for exact, with_seen, with_unseen in zip(
        [*body["per_target"], body["overall"]],
        [*seen["per_target"], seen["overall"]],
        [*unseen["per_target"], unseen["overall"]],
        strict=True,
    ):
        steps = (f"{exact['mean_steps']:.2f}", f"{exact['shortest_mean']:.2f}", f"{exact['ratio']:.3f}")
        words = (true_false(with_seen), true_false(with_unseen), f"{with_unseen['mean_steps']:.1f}")
        rows.append((exact["target"], percent(exact["success"], 0), *steps, *words))
    seconds, machine = body["seconds"], body["machine"]
    return (
        f"{table(head, rows)}\n\nOn {machine['cores']} cores ({machine['processor']}) the policy took "
        f"{seconds['policy']:.0f} s to train, the recogniser {seconds['recogniser']:.0f} s, the whole demo "
        f"{seconds['demo']:.0f} s."
    )


def demo_recognisers() -> str:
    """Both kinds of recogniser in the demo's kitchen."""
    rows = []
    for kind, described in result("demo")["recogniser"].items():
        for pictures, metrics in described["metrics"].items():
            rows.append((f"{kind}, {pictures}", *(f"{metrics[name]:.3f}" for name in ("auroc", "ap50", "mean_iou"))))
    return table(("recogniser", "AUROC", "AP50", "mean IoU"), rows)


def agents() -> str:
    """One agent for each bundled scene, and one for four."""
    head = (
        "scenes", "success", "x the fewest", "AUROC, AP50", "with held-out pictures", "found true, false",
        "with held-out pictures", "recogniser, policy",
    )  # fmt: skip
    rows = []
    for name in ("kitchen_1", "kitchen_2", "living_room_1", "living_room_2", "conference_room", "four_rooms"):
        body = result(f"scenes/{name}")
        metrics, word, seconds = body["recogniser"]["metrics"], body["stop_evaluation"], body["seconds"]
        overall = body["overall"]
        rows.append(
            (
                name.replace("four_rooms", "four rooms"),
                percent(overall["success"]),
                f"{overall['ratio']:.3f}",
                *(_auroc_ap50(metrics[kind]) for kind in ("seen pictures", "unseen pictures")),
                *(true_false(word[kind]["overall"]) for kind in ("pictures_seen", "pictures_unseen")),
                f"{seconds['recogniser']:.0f} s, {seconds['policy']:.0f} s",
            )
        )
    return table(head, rows)


def _auroc_ap50(metrics: dict[str, Any]) -> str:
    return f"{metrics['auroc']:.3f}, {metrics['ap50']:.3f}"


def elsewhere() -> str:
    """An agent whose recogniser was trained on pictures taken in other rooms."""
    body = result("elsewhere")
    there, here = body["recogniser"]["metrics"]["seen pictures"], body["detection"]["pictures_seen"]
    overall, word = body["overall"], body["stop_evaluation"]["pictures_seen"]["overall"]
    rows = (
        ("AUROC, AP50 on places of the other rooms that it was not trained on", _auroc_ap50(there)),
        ("AUROC, AP50 in the conference room", _auroc_ap50(here)),
        ("views without the target that look as if it were there", percent(here["false_positive_rate"])),
        ("success of the policy, x the fewest actions", f"{percent(overall['success'])}, {overall['ratio']:.3f}"),
        ('"found": true, false', true_false(word)),
    )
    return table(("conference room, recogniser trained elsewhere", ""), rows)


def sound_rooms() -> str:
    """Of how many generated rooms nothing is wrong."""
    body = result("rooms")
    sound = f"{body['sound']} of {len(body['rooms'])} rooms are sound"
    return f"{sound} ([benchmarks/rooms.json](../benchmarks/rooms.json))."


def own_room() -> str:
    """The room of the tutorial."""
    body = result("own_room")
    rows = [
        (
            row["target"],
            percent(row["success"], 0),
            *(f"{row[name]:.2f}" for name in ("mean_steps", "shortest_mean")),
            f"{row['ratio']:.3f}",
        )
        for row in [*body["per_target"], body["overall"]]
    ]
    return table(("target", "success", "actions", "shortest", "ratio"), rows)


def policies() -> str:
    """The worst of all policies that the default learner trained."""
    body = result("policies")
    ours = [row for row in body["summary"] if row["learner"] == "mirror-descent"]
    several = {setup["setup"] for setup in body["setups"] if len(setup["scenes"]) > 1}
    rows = []
    for label, group in (
        ("one room", [row for row in ours if row["setup"] not in several]),
        ("four rooms at once", [row for row in ours if row["setup"] in several]),
    ):
        worst = [max(row[name]["worst"] for row in group) for name in ("ratio", "seconds")]
        success = min(row["success"] for row in group)
        trained = sum(row["seeds"] for row in group)
        rows.append((label, str(trained), percent(success, 0), f"{worst[0]:.3f}", f"{worst[1]:.0f} s"))
    return table(("the worst policy of", "trained", "success", "x the fewest", "trained in"), rows)


def one_action() -> str:
    """How long an action takes, by backbone and threads."""
    rows = [
        (one["backbone"], str(one["threads"]), f"{one['ms']['whole']['median']:.0f} ms")
        for one in result("act")["actions"]
    ]
    return table(("backbone", "threads", "one action, median"), rows)


def robustness() -> str:
    """Searches when something is different from training, by condition."""
    rows = [
        (
            row["condition"],
            *(percent(row[name]) for name in ("true_found", "false_found", "not_found")),
            f"{row['found_steps']:.0f}",
        )
        for row in result("robustness")["conditions"]
    ]
    return table(("what is different", "found: true", "false", "not found", "actions"), rows)


def robot() -> str:
    """The simulated robot under all changes: agents trained on ever more kinds of views."""
    measured = [
        row
        for name in ("robot", "robot_default")
        for row in result(name)["rows"]
        if row["label"].startswith(("things nudged", "all changes"))
    ]
    rows = []
    for row in sorted(measured, key=lambda row: (*row["agent"].values(), row["searches"])):
        low, high = (100 * end for end in row["interval"])
        rows.append(
            (
                _trained_on(row["agent"]),
                str(row["searches"]),
                f"{percent(row['true_found'])} ({low:.1f}-{high:.1f})",
                *(percent(row[kind]) for kind in ("false_found", "not_found")),
                f"{row['actions']:.1f}",
            )
        )
    head = ("policy trained on", "searches", "found, true (95 % interval)", "found, false", "not found", "actions")
    return table(head, rows)


def _trained_on(agent: dict[str, float]) -> str:
    if not agent["view_augmentation"]:
        return "the views alone"
    if not agent["viewpoint_jitter_degrees"]:
        return "views in other light (the default)"
    return "views in other light and from near by"


def robot_runs() -> str:
    """The searches over rosbridge of which one is shown."""
    rows = []
    for seed in (2, 3, 6, 15):
        body = result(f"robot_run/seed_{seed}")
        ending = "found" if body["found"] else f"not found ({body['reason']})"
        rows.append((str(seed), ending, str(body["actions"]), f"{body['seconds']:.0f} s"))
    return table(("`--seed` of the bridge", "search", "actions", "took"), rows)


def int8() -> str:
    """What 8-bit numbers change."""
    body = result("export")["int8_over_fp32"]
    rows = [(f"{name}, int8 / fp32", f"{ratio:.2f}") for name, ratio in body.items()]
    return table(("", "ratio"), rows)
