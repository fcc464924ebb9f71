"""How plain code comes to produce tracked values: import hook, rewriter, tracked calls, runner."""
