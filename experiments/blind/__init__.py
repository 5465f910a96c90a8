"""A simulator that shares no code with `rwjax`, and the labelled rigs and logs that it makes.

* `truth`: numbers and state. `drive`, `motor`, `axis`, `simulator` and `sensors`: the physics from command to reading.
* `joint`: joints with a gear and a servo's loop, on their own; `experiments/joints` draws them.
* `rigs`, `commands`: what there is without effects. `draws`, `outside`: one entry for each effect and each cause outside the list.
* `cases` puts them together. `oracle` fits the simulator to its own logs. `sizes` finds the amplitude for a size.
* `messy`: rigs with small causes beside the large ones, wrong numbers in the file and runs that vary; `tangent` sizes what is small.
* `further`: one more run of a case's rig by a given command.
* `draw` lists cases in `sets/`, `campaign` has the library diagnose them, `inseparable` asks the oracle about what it named, `score` counts.

Only `campaign`, `calibrate` and `score` know the library. An effect needs its numbers in `truth`, its equation in the part where it acts, its draw, and
its entry in `draws.EFFECTS`.
"""
