"""Reading what others wrote: types checked, sizes limited, nothing run."""
