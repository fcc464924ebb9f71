"""Why a module runs plain."""


class NotParsed(Exception):
    """Plain Python cannot compile it either, and says it better; `__cause__` is what it says."""


class NotInstrumented(Exception):
    """Plain Python accepts it, but it could not be rewritten or compiled; the message says why."""


class NotNow(Exception):
    """The module is one of those that the rewriter needs, and is only just being imported."""
