"""What tests of the one core share lies beside this file, in `one_core_samples`."""
