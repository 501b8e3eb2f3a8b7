"""A simulated room with ground truth: people, glowing balls, interfering projections and six cameras.

After the set-up of Jin & Qian 2008, section 4. `world` computes the scene, `rendering` draws it for a camera,
`visibility` gives what a camera can see of it. The stages `sim.camera` and `sim.truth` and the command
`followspot simulate` use these three. Every frame follows from the parameters alone, so that instances in
different processes agree without communication.
"""
