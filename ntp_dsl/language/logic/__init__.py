"""What conditions imply."""
