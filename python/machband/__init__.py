"""machband: measure, analyze, generate and predict Mach bands.

Mach bands are the bright and dark lines that people see where the slope of luminance changes. This package contains the
whole program, as the command ``machband``, and its parts as functions on NumPy arrays:

========================  ==========================================================================================
`stimuli`                 a function for each kind of stimulus, which returns a `Stimulus`
`stimulus`, `light`,      codes, light, and the profile through the center, for loops over kinds
`profile`
`kinds`, `parameters`     what can be shown, and what can be varied
`interpolate`,            the functions behind the stimuli
`Transfer`,
`visual_angle`
`predict`                 how visible the bands of a stimulus are
`compare`, `steps`        how visible the difference between pictures is, and the steps of a picture's codes
`mesh`, `shade`           shaded meshes, and how smooth they are
`Definition`,             experiments: their conditions and trials, and simulated sessions
`simulate`
`read_results`,           recorded data
`analyze`, `verify`,
`export`
========================  ==========================================================================================

Light is linear and relative to the screen's maximum, 0 to 1. Angles are in degrees, times in seconds. Tables are
`pandas.DataFrame` objects if pandas is installed, and otherwise dicts of arrays. Long work shows its progress if tqdm is
installed, and stops on Ctrl+C. An invalid value, file or data set raises `Error`, a `ValueError`, in the words of the
command; data that cannot be analyzed raise `DataError`, an `Error`; an argument of the wrong type raises `TypeError`.
"""

from . import stimuli
from ._analysis import Analysis, Figure
from ._experiment import Definition, simulate
from ._machband import DataError, Error, __version__
from ._shading import Mesh, Shaded, mesh, shade
from ._stimulus import Parameter, Stimulus, Transfer, VisualAngle, interpolate, kinds, light, parameters, profile
from ._stimulus import stimulus, visual_angle
from ._study import DataWarning, Exported, Verification, analyze, export, read_results, verify
from ._vision import Comparison, Place, Prediction, Steps, compare, predict, steps

__all__ = [
    "Analysis",
    "Comparison",
    "DataError",
    "DataWarning",
    "Definition",
    "Error",
    "Exported",
    "Figure",
    "Mesh",
    "Parameter",
    "Place",
    "Prediction",
    "Shaded",
    "Steps",
    "Stimulus",
    "Transfer",
    "Verification",
    "VisualAngle",
    "__version__",
    "analyze",
    "compare",
    "export",
    "interpolate",
    "kinds",
    "light",
    "mesh",
    "parameters",
    "predict",
    "profile",
    "read_results",
    "shade",
    "simulate",
    "steps",
    "stimuli",
    "stimulus",
    "verify",
    "visual_angle",
]
