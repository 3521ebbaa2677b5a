"""Results as tables a person can read, with units."""

from hefting.report.estimates import comparison_report, estimate_report, methods_report
from hefting.report.inspection import inspection_report
from hefting.report.prediction import prediction_report
from hefting.report.printing import print_report

__all__ = [
    "comparison_report",
    "estimate_report",
    "inspection_report",
    "methods_report",
    "prediction_report",
    "print_report",
]
