"""Page: a report as one HTML file that needs no network; drawn by plotly from plain
data.

    html = identification_page(found.estimate, found.ingested, found.estimator)

Each section is a file; `hefting.page.html` puts them into a page. Text that comes from
files or users is escaped by `hefting.page.html`.
"""

from hefting.page.report import (
    Context,
    identification_page,
    inspection_page,
    prediction_page,
)

__all__ = ["Context", "identification_page", "inspection_page", "prediction_page"]
