"""The contacts in front of the middle of the thickness, with the strength and stiffness of their images behind."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.cohesion import Bond, find_bond
from orchestrator.pushover.contact.contact_search import Contacts, find_contacts
from orchestrator.pushover.contact.contact_tracking import Tracking
from orchestrator.pushover.contact.mortar import Mortar, find_mortar
from orchestrator.pushover.contact.possible_contacts import find_possible_contacts
from orchestrator.pushover.front import NEAR, FrontNodes
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.settings import ContactSettings


def joints_in_front(
    bodies: Bodies, meshes: BodyMeshes, front: FrontNodes, settings: ContactSettings, large_displacement: bool
) -> tuple[Contacts, Tracking | None, Bond | None, Mortar | None]:
    """Return what touches in the undeformed wall, what may touch (large displacements), and what holds it together, in
    front, all of it where the wall is solved whole; nodes have the numbers of front.py's rows."""
    contacts = find_contacts(bodies, meshes)
    tracking = find_possible_contacts(bodies, meshes, contacts) if large_displacement else None
    possible = tracking.possible if tracking else contacts
    bond = find_bond(bodies, meshes, contacts, len(possible), settings.softening_displacement)
    mortar = find_mortar(bodies, meshes, contacts, possible, tracking)
    place = [possible.slave_body, possible.master_body, possible.interface]
    if tracking:
        place = [tracking.pair, tracking.corner, tracking.master_face]
    kept, image = _images(front, np.column_stack(place), possible.slave_node, possible.point[:, 2])
    touching = kept[kept < len(contacts)]
    return (
        contacts.part(touching, front.row),
        tracking and tracking.part(kept, front.row),
        bond and bond.summed(kept, image),
        mortar and mortar.summed(kept, image),
    )


def _images(front: FrontNodes, keys: npt.NDArray, slave: IntArray, height: FloatArray) -> tuple[IntArray, IntArray]:
    """Return which contacts (c,) are in front, and of each contact the number among them of itself or its image.

    keys (c, k): what a contact and its image have in common besides their place; slave (c,): its node, height (c,): its
    z in m.
    """
    if not front.halves:
        everything = np.arange(len(slave))
        return everything, everything
    middle = 0.5 * (height.min() + height.max())
    off = np.abs(height - middle)
    level = np.unique(np.round(off / max(off.max(), 1e-300), 6), return_inverse=True)[1]
    column = np.where(slave >= 0, front.row[slave], -1)
    alike = np.unique(np.column_stack([keys, column, level]), axis=0, return_inverse=True)[1].ravel()
    kept = np.flatnonzero(height - middle <= NEAR * off.max())
    number = np.full(alike.max() + 1, -1)
    number[alike[kept]] = np.arange(len(kept))
    assert len(np.unique(alike[kept])) == len(kept), "no two contacts in front are alike"
    assert (number[alike] >= 0).all(), "every contact behind is the image of one in front"
    return kept, number[alike]
