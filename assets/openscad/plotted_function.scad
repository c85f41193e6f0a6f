n=30; function f(x,y)=4+2*sin(x*12)*cos(y*12);
pts=concat([for(i=[0:n],j=[0:n]) [i,j,f(i,j)]],[for(i=[0:n],j=[0:n]) [i,j,0]]);
N=(n+1)*(n+1); function id(i,j)=i*(n+1)+j;
faces=concat([for(i=[0:n-1],j=[0:n-1]) each [[id(i,j),id(i,j+1),id(i+1,j+1)],[id(i,j),id(i+1,j+1),id(i+1,j)]]],
[for(i=[0:n-1],j=[0:n-1]) [N+id(i,j),N+id(i+1,j),N+id(i+1,j+1),N+id(i,j+1)]],
[for(i=[0:n-1]) each [[id(i,0),id(i+1,0),N+id(i+1,0),N+id(i,0)],[id(i+1,n),id(i,n),N+id(i,n),N+id(i+1,n)],[id(n,i),id(n,i+1),N+id(n,i+1),N+id(n,i)],[id(0,i+1),id(0,i),N+id(0,i),N+id(0,i+1)]]]);
polyhedron(pts,faces);
