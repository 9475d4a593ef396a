"""Reading files from untrusted sources: types checked, sizes limited, nothing executed."""
