"""Poses, meshes and URDF files."""
