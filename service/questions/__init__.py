"""Questions about the cube of a study. Each question has its own file, and `every` lists all questions."""
