"""The counts that the law predicts, derived without the pruner."""
