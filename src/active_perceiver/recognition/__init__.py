"""Recognition: is the target in the view, and where. Importing this needs no torch; training does."""

from active_perceiver.recognition.metrics import RecognitionMetrics, box_iou
from active_perceiver.recognition.recogniser import Detection, Recogniser, RecogniserError, detect_table

__all__ = ["Detection", "RecognitionMetrics", "Recogniser", "RecogniserError", "box_iou", "detect_table"]
