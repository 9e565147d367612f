"""The public names with their types, for type checkers; `__init__.py` imports each when it is first used."""

from orchestrator.automatic import macroblocks_of as macroblocks_of
from orchestrator.bodies import Bodies as Bodies
from orchestrator.bodies import Body as Body
from orchestrator.bodies import make_bodies as make_bodies
from orchestrator.capacity import Capacity as Capacity
from orchestrator.capacity import find_capacity as find_capacity
from orchestrator.case import Case as Case
from orchestrator.case import read as read_case
from orchestrator.case import read_wall as read_wall
from orchestrator.errors import CaseError as CaseError
from orchestrator.errors import CollapseError as CollapseError
from orchestrator.errors import ConvergenceError as ConvergenceError
from orchestrator.errors import ResultError as ResultError
from orchestrator.joints import Assemblage as Assemblage
from orchestrator.joints import JointClass as JointClass
from orchestrator.joints import JointSettings as JointSettings
from orchestrator.joints import check_assemblage as check_assemblage
from orchestrator.joints import find_joints as find_joints
from orchestrator.limit_analysis import DeadLoad as DeadLoad
from orchestrator.limit_analysis import LimitAnalysis as LimitAnalysis
from orchestrator.limit_analysis import LimitAnalysisSettings as LimitAnalysisSettings
from orchestrator.limit_analysis import LimitState as LimitState
from orchestrator.limit_analysis import LiveLoad as LiveLoad
from orchestrator.limit_analysis import LoadCase as LoadCase
from orchestrator.limit_analysis import Loads as Loads
from orchestrator.limit_analysis import LoadSettings as LoadSettings
from orchestrator.limit_analysis import Mechanism as Mechanism
from orchestrator.limit_analysis import analyse as analyse
from orchestrator.limit_analysis import centres_of_rotation as centres_of_rotation
from orchestrator.limit_analysis import loads_on as loads_on
from orchestrator.limit_analysis import settle as settle
from orchestrator.macroblocks import MacroblockSettings as MacroblockSettings
from orchestrator.macroblocks import Partition as Partition
from orchestrator.macroblocks import merged as merged
from orchestrator.macroblocks import one_body as one_body
from orchestrator.macroblocks import one_body_per_block as one_body_per_block
from orchestrator.macroblocks import partition_of as partition_of
from orchestrator.masonry.readers import read_blocks as read_blocks
from orchestrator.masonry.wall import Block as Block
from orchestrator.masonry.wall import Wall as Wall
from orchestrator.masonry.wall import check_wall as check_wall
from orchestrator.meshing import BodyMeshes as BodyMeshes
from orchestrator.meshing import MeshSettings as MeshSettings
from orchestrator.meshing import mesh_bodies as mesh_bodies
from orchestrator.page.stored import StoredModel as StoredModel
from orchestrator.page.stored import StoredRun as StoredRun
from orchestrator.page.stored import read_run as read_run
from orchestrator.plots.pushover import curves as plot_curves
from orchestrator.plots.pushover import deformed as plot_deformed
from orchestrator.plots.walls import blocks as plot_blocks
from orchestrator.plots.walls import macroblocks as plot_macroblocks
from orchestrator.plots.walls import mechanism as plot_mechanism
from orchestrator.pushed import Pushed as Pushed
from orchestrator.pushed import push as push
from orchestrator.pushover.curve import pushover_increments as pushover_increments
from orchestrator.pushover.settings import ContactSettings as ContactSettings
from orchestrator.pushover.settings import ElasticSettings as ElasticSettings
from orchestrator.pushover.settings import NewtonSettings as NewtonSettings
from orchestrator.pushover.settings import SteppingSettings as SteppingSettings
from orchestrator.pushover.state import ContactStatus as ContactStatus
from orchestrator.pushover.state import Increment as Increment
from orchestrator.pushover.state import PushoverCurve as PushoverCurve
from orchestrator.results.summary import PushoverSummary as PushoverSummary
from orchestrator.results.summary import Summary as Summary
from orchestrator.results.summary import read_summary as read_summary

__all__ = [
    "Assemblage",
    "Block",
    "Bodies",
    "Body",
    "BodyMeshes",
    "Capacity",
    "Case",
    "CaseError",
    "CollapseError",
    "ContactSettings",
    "ContactStatus",
    "ConvergenceError",
    "DeadLoad",
    "ElasticSettings",
    "Increment",
    "JointClass",
    "JointSettings",
    "LimitAnalysis",
    "LimitAnalysisSettings",
    "LimitState",
    "LiveLoad",
    "LoadCase",
    "LoadSettings",
    "Loads",
    "MacroblockSettings",
    "Mechanism",
    "MeshSettings",
    "NewtonSettings",
    "Partition",
    "Pushed",
    "PushoverCurve",
    "PushoverSummary",
    "ResultError",
    "SteppingSettings",
    "StoredModel",
    "StoredRun",
    "Summary",
    "Wall",
    "analyse",
    "centres_of_rotation",
    "check_assemblage",
    "check_wall",
    "find_capacity",
    "find_joints",
    "loads_on",
    "macroblocks_of",
    "make_bodies",
    "merged",
    "mesh_bodies",
    "one_body",
    "one_body_per_block",
    "partition_of",
    "plot_blocks",
    "plot_curves",
    "plot_deformed",
    "plot_macroblocks",
    "plot_mechanism",
    "push",
    "pushover_increments",
    "read_blocks",
    "read_case",
    "read_run",
    "read_summary",
    "read_wall",
    "settle",
]

PUBLIC: dict[str, tuple[str, ...]]
RENAMED: dict[str, str]
