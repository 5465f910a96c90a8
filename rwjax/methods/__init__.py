"""Ways to identify a rig's free numbers from logs, each a function of a rig and logs: `rwjax.compare` runs them all."""
