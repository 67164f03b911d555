"""What is on a tree of vessels: where one goes on and another begins, and where it is narrow."""

from .lesion_measuring import lesions_after as lesions_after
from .lesion_value import HealthyPlace as HealthyPlace
from .lesion_value import Lesion as Lesion
from .lesions import SMALL_VESSEL as SMALL_VESSEL
from .lesions import find_lesions as find_lesions
from .lesions import lesion_after as lesion_after
from .lesions import lesions_within as lesions_within
from .marked_reference import lesion_against as lesion_against
from .marked_reference import lesions_against as lesions_against
from .narrowings import SMALLEST_DEGREE as SMALLEST_DEGREE
