"""Who shows messages and lets people drag what is in them (Section V of the paper).

`scene`, `handles` and `dragging` know what is shown, what can be dragged, and what a drag means;
the browser page and the interactive markers only draw that.
"""
