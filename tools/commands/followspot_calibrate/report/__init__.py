"""The HTML page of a calibration: one file that needs nothing else, with or without scripts.

A page is a title, a verdict, warnings and sections; this package offers the sections.
`calibration_page` puts the usual ones together.
"""

from followspot_calibrate.report.bars import hue_bars, interval_chart
from followspot_calibrate.report.charts import Course, drift_charts
from followspot_calibrate.report.page import Page, Section, Verdict, write_report
from followspot_calibrate.report.pictures import coverage
from followspot_calibrate.report.scene import poses
from followspot_calibrate.report.tables import camera_table, pair_table, plain_table
from followspot_calibrate.report.usual import calibration_page

__all__ = [
    "Course",
    "Page",
    "Section",
    "Verdict",
    "calibration_page",
    "camera_table",
    "coverage",
    "drift_charts",
    "hue_bars",
    "interval_chart",
    "pair_table",
    "plain_table",
    "poses",
    "write_report",
]
