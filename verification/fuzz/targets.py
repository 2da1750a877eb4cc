"""All targets by their names."""

from . import api, commands, files, kills, mechanisms, models, physics, shells

TARGETS = {target.name: target for target in (
    api.TARGET, commands.TARGET, models.TARGET, shells.TARGET, files.DAMAGE, files.EDITS,
    kills.TARGET, physics.DYNAMICS, physics.EXACT, physics.STATICS,
    mechanisms.MECHANISMS)}
