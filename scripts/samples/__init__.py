"""What make_samples.py is made of: geometry, pictures and writers shared by the sample assets."""
