"""Facts on working views, and drawings: angiograms, and the map of all angles."""

from .facts import WORST as WORST
from .facts import Stretch as Stretch
from .facts import ToldViews as ToldViews
from .facts import known_frame as known_frame
from .facts import lesion_stretch as lesion_stretch
from .facts import stent_stretch as stent_stretch
from .facts import views_document as views_document
from .film import Film as Film
from .page import HEADING as HEADING
from .page import NOT_TOLD as NOT_TOLD
from .page import views_part as views_part
from .picture import Look as Look
from .picture import views_drawing as views_drawing
from .picture import write_views as write_views
from .planned import PlannedViews as PlannedViews
from .planned import no_views as no_views
from .planned import planned_views as planned_views
from .planned import write_angiogram as write_angiogram
from .sight import Sight as Sight
from .sight import view_axes as view_axes
from .sight import view_toward as view_toward
