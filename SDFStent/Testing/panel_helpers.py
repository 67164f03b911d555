"""What several tests of the module ask for."""


def theThroat():
    """The narrowest place of the pulmonary artery."""
    from SDFStentLib.phantoms import branching_pulmonary_artery

    return branching_pulmonary_artery().throat.point


def settle(host, panel, seconds=60.0):
    """Let a panel run until nothing is under way or about to start."""
    host.processUntil(lambda: not panel.session.isBusy, seconds)
