"""What earlier studies are good for: their points, what their blocks took, and what another solver changed."""
