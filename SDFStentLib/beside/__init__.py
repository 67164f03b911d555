"""Treatments in a process beside the application, which has to draw."""

from .process import ProcessEnded as ProcessEnded
from .process import TreatmentProcess as TreatmentProcess
from .process import treatment_process as treatment_process
