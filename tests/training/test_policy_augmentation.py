"""What the policy is also trained on: the same scene, seen worse."""

from __future__ import annotations

import numpy as np
import pytest

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.task import SearchError, SearchTask
from active_perceiver.evaluation.detections import detect_all_views, detect_images
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.training.policy_augmentation import changed_observations, changed_view
from active_perceiver.vision.cache import scene_features
from active_perceiver.vision.image_changes import photometric


@pytest.fixture(scope="module")
def agent(agent_folder):
    return ActivePerceiver.from_pretrained(agent_folder, threads=1)


@pytest.fixture(scope="module")
def seen(agent, scene):
    return detect_all_views(scene, scene_features(scene, agent.backbone), agent.recogniser)


def test_looking_at_images_is_looking_at_cached_features(agent, scene, seen):
    count, calls = 11, []
    images = (scene.view(state) for state in range(count))
    features, scores, boxes = detect_images(
        images, count, agent.backbone, agent.recogniser, seen.target_embeddings, lambda *call: calls.append(call)
    )
    np.testing.assert_allclose(features, seen.view_features[:count], atol=2e-3)
    np.testing.assert_allclose(scores, seen.scores[:count], atol=0.02)
    sure = scores > 0.5
    np.testing.assert_allclose(boxes[sure], seen.boxes[:count][sure], atol=0.02)
    assert calls[-1] == (count, count)


def test_copies_differ_and_one_is_what_the_changed_image_gives(agent, scene, seen):
    threshold = agent.recogniser.threshold
    copies = changed_observations(seen, agent.backbone, agent.recogniser, threshold, 2, 10.0, seed=3)
    assert len(copies) == 2
    assert copies[0].pictures == seen.trained
    assert (copies[0].view_features != copies[1].view_features).any(axis=1).mean() > 0.8
    image = changed_view(scene.view(5), np.random.default_rng([3, 1, 5]), 10.0, scene.fov)
    expected, _, _ = detect_images([image], 1, agent.backbone, agent.recogniser, seen.target_embeddings)
    np.testing.assert_allclose(copies[1].view_features[5], expected[0], atol=1e-4)
    assert changed_observations(seen, agent.backbone, agent.recogniser, threshold, 0, 10.0, seed=3) == ()


def test_a_problem_draws_them_half_of_the_time(agent, scene, seen):
    task = SearchTask.from_scene(scene)
    own = seen.observations(0.5, seen.trained_pictures)
    copies = changed_observations(seen, agent.backbone, agent.recogniser, 0.5, 2, 10.0, seed=3)
    training_task = TrainingTask(task, own, copies)
    drawn = [training_task.drawn(np.random.default_rng(seed)) for seed in range(300)]
    assert 0.4 < np.mean([one is own for one in drawn]) < 0.6
    assert {id(one) for one in drawn} == {id(one) for one in (own, *copies)}
    assert TrainingTask(task, own).drawn(np.random.default_rng(0)) is own
    with pytest.raises(SearchError):
        TrainingTask(SearchTask.from_scene(scene, scene.target_names[:1]), own, copies)


def test_without_degrees_a_changed_view_shows_what_it_showed_in_other_light(scene):
    for seed in range(5):
        changed = changed_view(scene.view(5), np.random.default_rng(seed), 0.0, scene.fov)
        np.testing.assert_array_equal(changed, photometric(scene.view(5), np.random.default_rng(seed)))
        aside = changed_view(scene.view(5), np.random.default_rng(seed), 10.0, scene.fov)
        assert (aside != changed).mean() > 0.1
