"""The command `views`: what an angiographer sees of a lesion, and from where."""

from .command import views_command as views_command
