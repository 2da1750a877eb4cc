"""Result files: written by ``recorder``, read by ``reading``."""
