"""Names of functions of numpy that have a tracked version, known without importing numpy."""

SCALARS = frozenset(
    {
        "byte", "double", "float16", "float32", "float64", "half", "int16", "int32", "int64",
        "int8", "int_", "intc", "intp", "long", "short", "single",
    }
)  # fmt: skip
"""Classes of numpy's scalars that are called with numbers."""

CALLS = SCALARS | frozenset(
    {
        "arange", "average", "det", "interp", "inv", "matrix_power", "median", "polyval", "solve",
        "std", "trapezoid", "trapz", "var",
        "abs", "absolute", "acos", "acosh", "add", "amax", "amin", "append", "arccos",
        "arccosh", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "around", "array",
        "array_split", "asanyarray", "asarray", "ascontiguousarray", "asfortranarray",
        "asin", "asinh", "atan", "atan2", "atanh", "atleast_1d", "atleast_2d",
        "atleast_3d", "bitwise_and", "bitwise_invert", "bitwise_left_shift",
        "bitwise_not", "bitwise_or", "bitwise_right_shift", "bitwise_xor", "block",
        "broadcast_arrays", "broadcast_to", "cbrt", "ceil", "clip", "column_stack",
        "compress", "concat", "concatenate", "conj", "conjugate", "copy", "copysign",
        "copyto", "cos", "cosh", "cross", "cumprod", "cumsum", "deg2rad", "degrees",
        "delete", "diag", "diagflat", "diagonal", "diff", "divide", "dot", "dsplit",
        "dstack", "ediff1d", "einsum", "empty", "empty_like", "exp", "exp2",
        "expand_dims", "expm1", "extract", "eye", "fabs", "flip", "fliplr", "flipud",
        "float_power", "floor", "floor_divide", "fmax", "fmin", "fmod", "full",
        "full_like", "hsplit", "hstack", "hypot", "identity", "inner", "insert", "invert",
        "kron", "left_shift", "linspace", "log", "log10", "log1p", "log2", "matmul",
        "matrix_transpose", "max", "maximum", "mean", "meshgrid", "min", "minimum", "mod",
        "moveaxis", "multiply", "negative", "norm", "ones", "ones_like", "outer",
        "permute_dims", "positive", "pow", "power", "prod", "rad2deg", "radians", "ravel",
        "real", "reciprocal", "remainder", "repeat", "reshape", "resize", "right_shift",
        "rint", "roll", "rollaxis", "rot90", "round", "row_stack", "sin", "sinh", "sort",
        "split", "sqrt", "square", "squeeze", "stack", "subtract", "sum", "swapaxes",
        "take", "take_along_axis", "tan", "tanh", "tensordot", "tile", "trace",
        "transpose", "tril", "triu", "true_divide", "trunc", "unstack", "vdot", "vsplit",
        "vstack", "where", "zeros", "zeros_like",
    }
)  # fmt: skip
"""What rewritten code calls through `arrays.ADVICE`: functions by the last part of their name.

Also ``array``, which is `array.array` too (`sequences.ADVICE`).
"""
