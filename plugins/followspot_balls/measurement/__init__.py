"""How a ball shows in cameras: its outline, errors of its centre, and the point that several views see."""
