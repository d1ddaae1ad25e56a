"""What a person sees while a tree runs."""
