"""Design points for property tests: legal, of every scene, with the special values that break solvers."""

from hypothesis import strategies as st

from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.point import Design
from damperlab.worker.solver.particle import Particle, Wall

CYCLES = 8

damping_ratios = st.one_of(st.sampled_from([0.0038, 0.5]), st.floats(1e-3, 0.95))
frequency_ratios = st.one_of(st.sampled_from([0.5, 0.9, 1.0, 2.0]), st.floats(0.2, 4.0))
friction_ratios = st.one_of(st.sampled_from([0.4, 0.6, 0.7853981633974483, 1.0]), st.floats(1e-3, 2.0))
particles = st.builds(
    Particle,
    st.one_of(st.sampled_from([1.0, 2.0]), st.floats(0.02, 20.0)),
    st.one_of(st.sampled_from([0.0, 0.47]), st.floats(0.0, 0.9)),
    st.one_of(st.sampled_from([0.1, 1.0]), st.floats(1e-3, 3.0)),
    contact_time=st.none(),
    wall=st.none(),
    friction=st.none(),
    gravity=st.none(),
)
dragged = st.builds(
    lambda particle, friction, gravity: particle._replace(friction=friction, gravity=gravity),
    particles,
    st.floats(0.0, 2.0),
    st.floats(1e-2, 3.0),
)
"""Particles that rub and fall."""
dwelling = st.builds(
    lambda particle, contact_time: particle._replace(contact_time=contact_time),
    particles,
    st.floats(1e-3, 2.0),
)
compliant = st.builds(
    lambda particle, restitution, contact_time: particle._replace(
        restitution=restitution, wall=Wall(*wall_constants(restitution, contact_time, particle.mass_ratio))
    ),
    particles,
    st.floats(0.02, 0.9),
    st.floats(1e-3, 2.0),
)
alone = st.builds(Design, damping_ratios, frequency_ratios)
rubbing = st.builds(Design, damping_ratios, frequency_ratios, friction_ratios)
slipping = st.builds(
    lambda damping, frequency, share: Design(damping, frequency, min(share * frequency**2, 2.0)),
    st.floats(0.05, 0.95),
    frequency_ratios,
    st.floats(0.01, 0.95),
)
"""Friction below the largest force of inertia, which therefore never locks the mass, and transients that die soon."""
rattling = st.builds(Design, damping_ratios, frequency_ratios, st.just(0.0), particles)
hybrid = st.builds(Design, damping_ratios, frequency_ratios, friction_ratios, particles)
any_design = st.one_of(alone, rubbing, rattling, hybrid)
with_particle = st.one_of(rattling, hybrid)
