"""What deploy/fleet is made of: a fleet on one machine, and the accidents that it must survive."""
