"""What one browser asks for, and what it is answered."""
