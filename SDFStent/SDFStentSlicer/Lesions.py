"""The lesions of a vessel: found once, off the application's thread."""

from SDFStentLib.validation import InputError
from SDFStentLib.vessel import find_lesions

from .Portions import inPortions


def withSections(lesions):
    """The same lesions, their sections cut: the application's thread would wait for those that it tells of."""
    for lesion in lesions:
        _cut = lesion.section
    return lesions


class LesionSearch:
    """The lesions of one vessel with one centerline. No nodes in here.

    `found` is None until `portions` was run to its end, then a tuple of the library's `Lesion`, the tightest first; `sentence`
    says why it is empty where the vessel could not be searched, `remark` what to know of the vessel.
    """

    def __init__(self, inputs):
        """`inputs()` is a generator that yields None in between and returns the remark and what `find_lesions` takes."""
        self._inputs = inputs
        self.found, self.sentence, self.remark = None, "", ""

    def portions(self):
        """Search; yields None until it is done. Does nothing when it is."""
        if self.found is not None:
            return
        try:
            self.remark, inputs = yield from self._inputs()
            self.found = yield from inPortions(lambda: withSections(find_lesions(*inputs)))
        except InputError as error:
            self.found, self.sentence = (), str(error)
