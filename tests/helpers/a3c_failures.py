"""Workers that fail, in a module of their own so that other processes can import them."""

import os
import signal

from active_perceiver.policies.a3c.worker import EpisodeWorker


class FailingWorker(EpisodeWorker):
    def episode(self, shared, next_update):
        if self.episodes >= 1:
            raise ZeroDivisionError("the floor gave way")
        return super().episode(shared, next_update)


class KilledWorker(EpisodeWorker):
    def episode(self, shared, next_update):
        os.kill(os.getpid(), signal.SIGKILL)
