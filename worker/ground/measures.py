"""Measures of the response of a design to a record."""

from dataclasses import asdict, dataclass

from damperlab.studies.shapes import Count, Measured


@dataclass(frozen=True)
class GroundResponse:
    """Response of a design to a record. Peaks are true extrema, and rms values are exact integrals over `duration_s`.

    Parameters
    ----------
    peak_relative_displacement_m, rms_relative_displacement_m : float
        Peak and rms of x − z, the displacement of the primary mass relative to the base.
    peak_absolute_displacement_m, rms_absolute_displacement_m : float
        Peak and rms of x, the displacement of the primary mass from its initial position. The motion of the base is the
        record integrated twice.
    peak_absolute_acceleration_m_s2, rms_absolute_acceleration_m_s2 : float
        Peak and rms of x'', with the contact forces of compliant walls. The accelerations of instantaneous impacts are
        infinite and left out.
    impacts : int
        Number of impacts.
    impact_speed_max_m_s : float
        Largest approach speed of an impact.
    stick_fraction : float
        Fraction of the time in which friction holds the mass.
    work_in_j, loss_viscous_j, loss_friction_j, loss_impact_j : float
        Work of the base, and energy lost in the dashpot, by friction and in impacts.
    energy_residual : float
        Error of the energy balance, relative to the largest of work, losses, stored energy and peak energy.
    duration_s : float
        Total duration of the record and the tail.
    end_relative_displacement_m, end_relative_velocity_m_s : float
        Final displacement and velocity relative to the base.
    status : int
        Value of `damperlab.studies.variables.Status`; 0 if the integration reached the end.
    loss_particle_j : float or None
        Energy lost by friction of the particle in its cavity; None without such friction.
    """

    peak_relative_displacement_m: Measured
    rms_relative_displacement_m: Measured
    peak_absolute_displacement_m: Measured
    rms_absolute_displacement_m: Measured
    peak_absolute_acceleration_m_s2: Measured
    rms_absolute_acceleration_m_s2: Measured
    impacts: Count
    impact_speed_max_m_s: Measured
    stick_fraction: Measured
    work_in_j: Measured
    loss_viscous_j: Measured
    loss_friction_j: Measured
    loss_impact_j: Measured
    energy_residual: Measured
    duration_s: Measured
    end_relative_displacement_m: Measured
    end_relative_velocity_m_s: Measured
    status: Count
    loss_particle_j: float | None = None

    def values(self) -> dict[str, float | int]:
        """Return the measures by name. `loss_particle_j` is left out if it is None."""
        return {name: value for name, value in asdict(self).items() if value is not None}
