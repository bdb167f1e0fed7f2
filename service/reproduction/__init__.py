"""The paper reproduced: sections that compute its figures and tables anew, and the report made of them."""
