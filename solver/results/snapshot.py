"""What a frame shows of a state."""

from .stresses import recovered


def snapshot(system, state, place, reactions, stresses):
    """``{name: values}`` of a frame, in the order of ``layout.Sizes.fields``.

    Args:
        system: ``System``.
        state: ``State``.
        place: its ``Place``.
        reactions: ``Reactions``; None of a shell that has no supports.
        stresses: whether they are recorded.
    """
    model, displacement = system.model, system.displacement(state)
    fields = {"displacement": displacement, "normal": system.nodal_normals(place)}
    if len(model.normals) > len(model.nodes):
        fields["director"] = place.start.p.copy()
    if reactions is not None:
        fields |= {"reaction": reactions.forces, "reaction_moment": reactions.moments}
    fields["strain_energy"] = place.start.energy.copy()
    if stresses:
        found = recovered(model, place.start.e, place.start.b, displacement, place.start.p)
        fields |= {"membrane_force": found.n, "moment": found.m, "shear_force": found.q,
                   "von_mises": found.von_mises,
                   "nodal_von_mises": found.nodal().von_mises[model.directors.first[:-1]]}
    return fields
