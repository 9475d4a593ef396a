"""Reading files of others: types checked, sizes limited, nothing executed."""
