"""The largest sphere inside a lumen round a place."""

from .climb import InscribedSpheres as InscribedSpheres
from .climb import Until as Until
from .followed import FollowedWall as FollowedWall
from .followed import followed_wall as followed_wall
from .inscribed import SphereSearch as SphereSearch
from .inscribed import StationSearch as StationSearch
from .inscribed import inscribed_spheres as inscribed_spheres
from .local_surface import AROUND as AROUND
from .local_surface import SOME as SOME
from .local_surface import LocalSurface as LocalSurface
from .local_surface import index_within as index_within
from .local_surface import known_index as known_index
from .local_surface import some_corners as some_corners
from .own import with_own_spheres as with_own_spheres
from .passing import widest_passing as widest_passing
from .passing import with_passing as with_passing
from .point_lumen import rough_radii as rough_radii
