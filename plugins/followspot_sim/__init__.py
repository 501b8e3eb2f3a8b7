"""A simulated room with ground truth: people, glowing balls, interfering projections and six cameras.

After the set-up of Jin & Qian 2008, section 4. `world` says what happens, `picture` what a camera
sees of it, `visibility` what it could see; the stages `sim.camera` and `sim.truth` and the command
`followspot simulate` stand on these three. Everything follows from the parameters, frame by frame,
so that instances in different processes agree without talking to each other.
"""
