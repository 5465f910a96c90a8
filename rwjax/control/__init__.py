"""Control of the axis, designed on the plant that was identified."""
