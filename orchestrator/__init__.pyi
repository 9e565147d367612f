"""The public names with their types, for type checkers; `__init__.py` imports each when it is first used."""

from orchestrator.app.pushed import Pushed as Pushed
from orchestrator.app.pushed import push as push
from orchestrator.app.refining import push_and_refine as push_and_refine
from orchestrator.assessment.capacity import Capacity as Capacity
from orchestrator.assessment.capacity import find_capacity as find_capacity
from orchestrator.basis.errors import CaseError as CaseError
from orchestrator.basis.errors import CollapseError as CollapseError
from orchestrator.basis.errors import ConvergenceError as ConvergenceError
from orchestrator.basis.errors import ResultError as ResultError
from orchestrator.limit_analysis import LimitAnalysis as LimitAnalysis
from orchestrator.limit_analysis import LimitAnalysisSettings as LimitAnalysisSettings
from orchestrator.limit_analysis import LimitState as LimitState
from orchestrator.limit_analysis import Mechanism as Mechanism
from orchestrator.limit_analysis import analyse as analyse
from orchestrator.limit_analysis import centres_of_rotation as centres_of_rotation
from orchestrator.limit_analysis import settle as settle
from orchestrator.loads import DeadLoad as DeadLoad
from orchestrator.loads import LiveLoad as LiveLoad
from orchestrator.loads import LoadCase as LoadCase
from orchestrator.loads import Loads as Loads
from orchestrator.loads import LoadSettings as LoadSettings
from orchestrator.loads import load_cases as load_cases
from orchestrator.loads import loads_on as loads_on
from orchestrator.macroblocks.automatic import macroblocks_of as macroblocks_of
from orchestrator.macroblocks.bodies import Bodies as Bodies
from orchestrator.macroblocks.bodies import Body as Body
from orchestrator.macroblocks.bodies import make_bodies as make_bodies
from orchestrator.macroblocks.criteria import MacroblockSettings as MacroblockSettings
from orchestrator.macroblocks.criteria import Partition as Partition
from orchestrator.macroblocks.criteria import merged as merged
from orchestrator.macroblocks.criteria import one_body as one_body
from orchestrator.macroblocks.criteria import one_body_per_block as one_body_per_block
from orchestrator.macroblocks.criteria import partition_of as partition_of
from orchestrator.masonry.interfaces import Interfaces as Interfaces
from orchestrator.masonry.joints import Assemblage as Assemblage
from orchestrator.masonry.joints import JointClass as JointClass
from orchestrator.masonry.joints import JointSettings as JointSettings
from orchestrator.masonry.joints import check_assemblage as check_assemblage
from orchestrator.masonry.joints import find_joints as find_joints
from orchestrator.masonry.sources.block_files import read_blocks as read_blocks
from orchestrator.masonry.wall import Block as Block
from orchestrator.masonry.wall import Wall as Wall
from orchestrator.masonry.wall import check_wall as check_wall
from orchestrator.present.plots.pushover_pictures import curves as plot_curves
from orchestrator.present.plots.pushover_pictures import deformed as plot_deformed
from orchestrator.present.plots.wall_pictures import blocks as plot_blocks
from orchestrator.present.plots.wall_pictures import macroblocks as plot_macroblocks
from orchestrator.present.plots.wall_pictures import mechanism as plot_mechanism
from orchestrator.pushover.increments import ContactStatus as ContactStatus
from orchestrator.pushover.increments import Increment as Increment
from orchestrator.pushover.increments import PushoverCurve as PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes as BodyMeshes
from orchestrator.pushover.meshing import MeshSettings as MeshSettings
from orchestrator.pushover.meshing import mesh_bodies as mesh_bodies
from orchestrator.pushover.path.curve import pushover_increments as pushover_increments
from orchestrator.pushover.settings import ContactSettings as ContactSettings
from orchestrator.pushover.settings import ElasticSettings as ElasticSettings
from orchestrator.pushover.settings import NewtonSettings as NewtonSettings
from orchestrator.pushover.settings import SteppingSettings as SteppingSettings
from orchestrator.settings.case import Case as Case
from orchestrator.settings.case import read as read_case
from orchestrator.settings.case import read_wall as read_wall
from orchestrator.storage.stored_run import StoredModel as StoredModel
from orchestrator.storage.stored_run import StoredRun as StoredRun
from orchestrator.storage.stored_run import read_run as read_run
from orchestrator.storage.summary import PushoverSummary as PushoverSummary
from orchestrator.storage.summary import Summary as Summary
from orchestrator.storage.summary import read_summary as read_summary

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
    "Interfaces",
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
    "load_cases",
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
