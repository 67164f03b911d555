"""Proof that a surface is sound, and that a deployment left it so."""

from .certificate import CERTIFIED as CERTIFIED
from .certificate import CERTIFIED_IN_PIECES as CERTIFIED_IN_PIECES
from .certificate import CERTIFIED_OPEN as CERTIFIED_OPEN
from .certificate import NOT_CERTIFIED as NOT_CERTIFIED
from .certificate import NOT_READY as NOT_READY
from .certificate import Certificate as Certificate
from .certificate import certificate_of as certificate_of
from .certificate import certify as certify
from .certificate import said_of as said_of
from .comparison import Comparison as Comparison
from .comparison import Verdict as Verdict
from .face_quality import smallest_angles as smallest_angles
from .fitness import fitness_after as fitness_after
from .fitness import known_faults as known_faults
from .intersections import self_intersecting_triangles as self_intersecting_triangles
from .promises import NARROWER as NARROWER
from .promises import NOTICEABLY_NARROWER as NOTICEABLY_NARROWER
from .promises import WIDER as WIDER
from .promises import LumenCheck as LumenCheck
from .promises import MotionCheck as MotionCheck
from .promises import WallCheck as WallCheck
from .surface_check import SurfaceCheck as SurfaceCheck
from .surface_check import check_surface as check_surface
