"""COCO files of labelling tools: boxes as pycocotools reads them; what is odd is counted, what is wrong is named."""

import copy
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.datasets.coco.photograph_names import PhotographNames
from active_perceiver.datasets.coco.reader import labelled_from_coco, read_coco
from active_perceiver.datasets.coco.writer import coco_annotations, export_coco
from active_perceiver.scenes import SceneError
from active_perceiver.scenes.box_labels import label_states, with_boxes
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED

NAMES = ("a.jpg", "b.jpg", "c.jpg")
SIZES = np.tile([200, 100], (3, 1))
GOOD = {
    "images": [
        {"id": 3, "file_name": "a.jpg", "width": 200, "height": 100},
        {"id": 4, "file_name": "b.jpg", "width": 200, "height": 100},
    ],
    "annotations": [{"id": 1, "image_id": 3, "category_id": 7, "bbox": [20, 10, 40, 30], "iscrowd": 0}],
    "categories": [{"id": 7, "name": "mug"}, {"id": 9, "name": "Tea Pot"}],
}


@pytest.fixture
def good():
    return copy.deepcopy(GOOD)


def read(content, tmp_path, names=NAMES, sizes=SIZES, targets=("mug", "tea_pot")):
    path = tmp_path / "coco.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return read_coco(path, names, sizes, targets)


def annotation(bbox, image=3, category=7, **others):
    return {"id": 50, "image_id": image, "category_id": category, "bbox": bbox, "iscrowd": 0, **others}


def test_boxes_are_fractions_and_listed_images_are_labelled(good, tmp_path):
    coco = read(good, tmp_path)
    np.testing.assert_allclose(coco.boxes[0, 0], [0.2, 0.25, 0.2, 0.3])
    assert np.isnan(coco.boxes).all(-1).sum() == 5
    assert coco.listed.tolist() == [True, True, False]
    assert (coco.report.images, coco.report.boxes) == (2, 1)
    assert coco.report.notes == ("no box of tea_pot",)


def test_the_largest_of_several_is_taken_whatever_their_order(good, tmp_path):
    boxes = [[0, 0, 10, 10], [50, 50, 40, 40], [10, 10, 20, 20]]
    good["annotations"] = [annotation(box) for box in boxes]
    coco = read(good, tmp_path)
    np.testing.assert_allclose(coco.boxes[0, 0], [0.35, 0.7, 0.2, 0.4])
    assert any(note.startswith("2 boxes left out, as another") for note in coco.report.notes)


def test_crowds_strangers_and_clipped_ones_are_counted(good, tmp_path):
    good["categories"].append({"id": 11, "name": "chair"})
    good["images"].append({"id": 5, "file_name": "elsewhere.jpg", "width": 10, "height": 10})
    good["annotations"] += [
        annotation([0, 0, 99, 99], iscrowd=1),
        annotation([0, 0, 5, 5], category=11),
        annotation([-20, 50, 40, 80], image=4, category=9),
        annotation([0, 0, 5, 5], image=5),
    ]
    coco = read(good, tmp_path)
    np.testing.assert_allclose(coco.boxes[1, 1], [0.05, 0.75, 0.1, 0.5])
    notes = "\n".join(coco.report.notes)
    for text in ("1 boxes of crowds", "1 boxes stuck out", "no target: chair (1 boxes)", "here: elsewhere.jpg"):
        assert text in notes


def test_images_without_a_size_or_of_another_scale_are_fine(good, tmp_path):
    good["images"][0].update(width=None, height=None)
    good["images"][1].update(width=400, height=200)
    good["annotations"].append(annotation([40, 20, 80, 60], image=4))
    coco = read(good, tmp_path)
    np.testing.assert_allclose(coco.boxes[0, 0], coco.boxes[1, 0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.pop("images"), "images is missing"),
        (lambda c: c.update(annotations={}), "annotations is not a list"),
        (lambda c: c["images"].append(3), r"images\[2\] is not an object"),
        (lambda c: c["images"][0].pop("file_name"), r"images\[0\].file_name is missing"),
        (lambda c: c["images"][1].update(id="4"), r"images\[1\].id is '4', expected a whole number"),
        (lambda c: c["images"][1].update(id=3), r"images\[1\].id is 3, as that of an image before"),
        (lambda c: c["images"][0].update(width=100, height=200), r"a.jpg has 100 x 200 .* upright it has 200 x 100"),
        (lambda c: c["images"][0].update(width=-5), r"images\[0\].width and height"),
        (lambda c: c["annotations"][0].update(image_id=99), r"annotations\[0\].image_id is 99"),
        (lambda c: c["annotations"][0].update(category_id=99), r"annotations\[0\].category_id is 99"),
        (lambda c: c["annotations"][0].pop("bbox"), r"annotations\[0\].bbox is None"),
        (lambda c: c["annotations"][0].update(bbox=[1, 2, 3]), r"annotations\[0\].bbox"),
        (lambda c: c["annotations"][0].update(bbox=[1, 2, 3, float("nan")]), r"annotations\[0\].bbox"),
        (lambda c: c["annotations"][0].update(bbox=[1, 2, "3", 4]), r"annotations\[0\].bbox"),
        (lambda c: c["annotations"][0].update(bbox=[1, 2, 0, 4]), "no size"),
        (lambda c: c["annotations"][0].update(bbox=[300, 2, 5, 4]), "no size within"),
        (lambda c: c["categories"][1].update(id=7), r"categories\[1\].id is 7"),
        (lambda c: [image.update(file_name="x.jpg") for image in c["images"]], "lists none of the 3 photographs"),
    ],
)
def test_what_is_wrong_is_named(good, tmp_path, change, message):
    change(good)
    with pytest.raises(SceneError, match=message):
        read(good, tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "[]", "null", '"coco"', "{" + "\x00"])
def test_what_is_no_coco_is_refused(tmp_path, text):
    with pytest.raises(SceneError, match="JSON"):
        read(text, tmp_path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"nothing\.json"):
        read_coco(tmp_path / "nothing.json", NAMES, SIZES, ())


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("my photo 1.jpg", 0),
        ("images/my photo 1.jpg", 0),
        ("images\\1/cb0618f6-my_photo_1.jpg", 0),
        ("..\\..\\label-studio\\media\\upload\\4\\cb0618f6-my_photo_1.jpg", 0),
        ("/data/local-files/?d=room/my%20photo%201.jpg", 0),
        ("https://bucket.example/room/my%20photo%201.jpg?X-Signature=a%2Fb", 0),
        ("s3://bucket/left/IMG_2.jpg", 1),
        ("right/IMG_2.jpg", 2),
        ("cb0618f6-100%25.jpg", 3),
        ("100%.jpg", 3),
        ("deadbeef-deadbeef-4.jpg", 4),
        ("deadbeef-4.jpg", 4),
    ],
)
def test_names_of_labelling_tools(written, meant):
    names = PhotographNames(("my photo 1.jpg", "left/IMG_2.jpg", "right/IMG_2.jpg", "100%.jpg", "deadbeef-4.jpg"))
    assert names.find(written) == [meant]


def test_a_name_that_may_be_two_photographs_is_refused(good, tmp_path):
    good["images"] = [{"id": 3, "file_name": "cb0618f6-a.jpg", "width": 200, "height": 100}]
    good["annotations"] = []
    with pytest.raises(SceneError, match=r"'cb0618f6-a.jpg' may be left/a.jpg and right/a.jpg"):
        read(good, tmp_path, ("left/a.jpg", "right/a.jpg"), SIZES[:2])


@given(
    boxes=st.lists(
        st.tuples(
            st.integers(0, 2),
            st.integers(0, 2),
            st.integers(0, 150),
            st.integers(0, 70),
            st.integers(1, 50),
            st.integers(1, 30),
        ),
        max_size=12,
    )
)
def test_the_same_as_pycocotools(boxes, tmp_path_factory):
    from pycocotools.coco import COCO

    folder = tmp_path_factory.mktemp("coco")
    content = {
        "images": [
            {"id": index + 1, "file_name": name, "width": 200, "height": 100} for index, name in enumerate(NAMES)
        ],
        "categories": [{"id": index + 1, "name": f"t{index}"} for index in range(3)],
        "annotations": [
            annotation(list(box), image + 1, category + 1) | {"id": index + 1, "area": box[2] * box[3]}
            for index, (image, category, *box) in enumerate(boxes)
        ],
    }
    ours = read(content, folder, targets=("t0", "t1", "t2"))
    theirs = COCO(folder / "coco.json")
    for image in range(3):
        for category in range(3):
            found = theirs.loadAnns(theirs.getAnnIds(imgIds=[image + 1], catIds=[category + 1]))
            assert np.isnan(ours.boxes[image, category]).all() == (not found)
            if found:
                x, y, width, height = max(found, key=lambda one: one["area"])["bbox"]
                largest = [(x + width / 2) / 200, (y + height / 2) / 100, width / 200, height / 100]
                assert ours.boxes[image, category, 2:].prod() == pytest.approx(largest[2] * largest[3])
                if sum(one["area"] == width * height for one in found) == 1:
                    np.testing.assert_allclose(ours.boxes[image, category], largest)


def test_pycocotools_opens_what_is_exported(scene, tmp_path):
    from pycocotools.coco import COCO

    export_coco(scene, tmp_path / "out")
    coco = COCO(tmp_path / "out" / "annotations.json")
    assert len(coco.getImgIds()) == len(scene)
    assert len(coco.getAnnIds()) == int((scene.areas > 0).sum())
    image = coco.loadImgs([5])[0]
    assert (tmp_path / "out" / image["file_name"]).read_bytes() == scene.views[4]
    for entry in coco.loadAnns(coco.getAnnIds(imgIds=[5])):
        box = scene.boxes[4, entry["category_id"] - 1] * scene.image_size
        np.testing.assert_allclose(entry["bbox"], [*(box[:2] - box[2:] / 2), *box[2:]], atol=1e-3)


def test_boxes_come_back_into_the_scene(scene, tmp_path):
    content = coco_annotations(scene)
    content["images"] = content["images"][:20]
    content["annotations"] = [
        entry for entry in content["annotations"] if entry["image_id"] <= 20 and entry["category_id"] == 1
    ]
    path = tmp_path / "coco.json"
    path.write_text(json.dumps(content))
    nothing = with_boxes(scene, {view: np.full((3, 4), np.nan) for view in range(len(scene))}, UNLABELLED)
    labelled, report = labelled_from_coco(nothing, path)
    assert label_states(labelled).tolist() == [LABELLED] * 20 + [UNLABELLED] * (len(scene) - 20)
    np.testing.assert_allclose(labelled.boxes[:20, 0], scene.boxes[:20, 0], atol=1e-5)
    assert np.isnan(labelled.boxes[:, 1:]).all()
    assert report.images == 20


def test_the_other_views_stay_as_they_are(scene, tmp_path):
    """A file that lists one view, with a proposal in it, changes that view only."""
    content = coco_annotations(scene)
    content["images"] = [content["images"][7] | {"proposed": True}]
    content["annotations"] = [annotation([1, 2, 30, 20], image=8, category=2)]
    path = tmp_path / "coco.json"
    path.write_text(json.dumps(content))
    labelled, _ = labelled_from_coco(scene, path)
    others = np.arange(len(scene)) != 7
    np.testing.assert_array_equal(labelled.boxes[others], scene.boxes[others])
    np.testing.assert_allclose(labelled.boxes[7, 1] * scene.image_size, [16, 12, 30, 20], rtol=1e-5)
    assert labelled.labels[7] == PROPOSED
    assert (labelled.labels[others] == LABELLED).all()


def test_with_boxes_refuses_what_does_not_fit(scene):
    with pytest.raises(SceneError, match="none has the number"):
        with_boxes(scene, {len(scene): np.full((3, 4), np.nan)})
    with pytest.raises(SceneError, match="shape"):
        with_boxes(scene, {0: np.full((2, 4), np.nan)})
    with pytest.raises(SceneError, match="unlabelled"):
        with_boxes(scene, {0: np.full((3, 4), 0.5)}, UNLABELLED)
    assert with_boxes(scene, {0: scene.boxes[0]}).labels is None


def test_a_key_that_is_there_twice_is_refused(good, tmp_path):
    text = json.dumps(good).replace('"bbox": [20, 10, 40, 30]', '"bbox": [20, 10, 40, 30], "bbox": [0, 0, 1, 1]')
    with pytest.raises(SceneError, match=r"coco\.json: key 'bbox' is there twice in one object; remove one of them"):
        read(text, tmp_path)
