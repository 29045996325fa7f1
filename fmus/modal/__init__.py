"""What wheel and rail share: modes, their data files, and the component and kernels of a modal structure."""
