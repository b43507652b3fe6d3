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

from . import stimuli as stimuli
from ._analysis import Analysis as Analysis, Figure as Figure
from ._experiment import Definition as Definition, simulate as simulate
from ._machband import DataError as DataError, Error as Error, __version__ as __version__
from ._shading import Mesh as Mesh, Shaded as Shaded, mesh as mesh, shade as shade
from ._stimulus import Parameter as Parameter, Stimulus as Stimulus, Transfer as Transfer, VisualAngle as VisualAngle
from ._stimulus import interpolate as interpolate, kinds as kinds, light as light, parameters as parameters
from ._stimulus import profile as profile, stimulus as stimulus, visual_angle as visual_angle
from ._study import DataWarning as DataWarning, Exported as Exported, Verification as Verification
from ._study import analyze as analyze, export as export, read_results as read_results, verify as verify
from ._vision import Comparison as Comparison, Place as Place, Prediction as Prediction, Steps as Steps
from ._vision import compare as compare, predict as predict, steps as steps
